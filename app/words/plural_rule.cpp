#include "app/words/plural_rule.h"

#include <optional>

namespace limberg {
namespace {

/// An expression of C over n: ?:, ||, &&, comparisons, + - * / %, !, brackets. Nothing: it is none, or divides by 0.
class Expression {
 public:
  Expression(std::string_view text, uint64_t n) : text_(text), n_(n) {}
  std::optional<uint64_t> value() {
    const uint64_t v = choice();
    skip();
    return wrong_ || at_ != text_.size() ? std::nullopt : std::optional(v);
  }

 private:
  static constexpr int kDeepest = 40;

  void skip() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
  }
  bool take(std::string_view sign) {
    skip();
    if (text_.substr(at_, sign.size()) != sign) return false;
    at_ += sign.size();
    return true;
  }
  uint64_t choice() {
    if (++deep_ > kDeepest) wrong_ = true;
    if (wrong_) return 0;
    const uint64_t condition = binary(0);
    uint64_t v = condition;
    if (take("?")) {
      const uint64_t yes = choice();
      if (!take(":")) wrong_ = true;
      const uint64_t no = choice();
      v = condition ? yes : no;
    }
    --deep_;
    return v;
  }
  uint64_t binary(int level) {
    static constexpr std::string_view kSigns[][4] = {{"||"},     {"&&"},         {"==", "!="}, {"<=", ">=", "<", ">"},
                                                     {"+", "-"}, {"*", "/", "%"}};
    constexpr int kLevels = 6;
    if (level == kLevels) return unary();
    uint64_t a = binary(level + 1);
    for (bool more = true; more && !wrong_;) {
      more = false;
      for (const std::string_view sign : kSigns[level])
        if (!sign.empty() && take(sign)) {
          a = joined(sign, a, binary(level + 1)), more = true;
          break;
        }
    }
    return a;
  }
  uint64_t joined(std::string_view sign, uint64_t a, uint64_t b) {
    if (sign == "||") return a || b;
    if (sign == "&&") return a && b;
    if (sign == "==") return a == b;
    if (sign == "!=") return a != b;
    if (sign == "<=") return a <= b;
    if (sign == ">=") return a >= b;
    if (sign == "<") return a < b;
    if (sign == ">") return a > b;
    if (sign == "+") return a + b;
    if (sign == "-") return a - b;
    if (sign == "*") return a * b;
    if (b == 0) wrong_ = true;
    return b == 0 ? 0 : sign == "/" ? a / b : a % b;
  }
  uint64_t unary() {
    if (take("!")) {
      if (++deep_ > kDeepest) wrong_ = true;
      return wrong_ ? 0 : !unary();
    }
    if (take("(")) {
      const uint64_t v = choice();
      if (!take(")")) wrong_ = true;
      return v;
    }
    if (take("n")) return n_;
    skip();
    if (at_ >= text_.size() || text_[at_] < '0' || text_[at_] > '9') {
      wrong_ = true;
      return 0;
    }
    uint64_t v = 0;
    while (at_ < text_.size() && text_[at_] >= '0' && text_[at_] <= '9' && v < 1'000'000)
      v = 10 * v + uint64_t(text_[at_++] - '0');
    return v;
  }

  std::string_view text_;
  uint64_t n_;
  size_t at_ = 0;
  int deep_ = 0;
  bool wrong_ = false;
};

}  // namespace

PluralRule::PluralRule(std::string_view text, std::string& wrong) {
  const auto after = [&](std::string_view name) -> std::string_view {
    const size_t at = text.find(name);
    if (at == std::string_view::npos) return {};
    const std::string_view rest = text.substr(at + name.size());
    return rest.substr(0, rest.find(';'));
  };
  const std::optional<uint64_t> forms = Expression(after("nplurals="), 0).value();
  const std::string rule(after("plural="));
  constexpr uint64_t kTried = 1000;
  bool sound = forms && *forms >= 1 && *forms <= kMostForms && rule.size() < 500;
  for (uint64_t n = 0; sound && n <= kTried; ++n) {
    const auto form = Expression(rule, n).value();
    sound = form && *form < *forms;
  }
  wrong = sound ? "" : "Plural-Forms: \"" + std::string(text) + "\" is no rule; expected nplurals=2; plural=(n != 1);";
  if (sound) forms_ = int(*forms), expression_ = rule;
}

int PluralRule::form(int64_t n) const {
  const auto form = Expression(expression_, uint64_t(n < 0 ? -n : n)).value();
  return form && *form < uint64_t(forms_) ? int(*form) : 0;
}

}  // namespace limberg
