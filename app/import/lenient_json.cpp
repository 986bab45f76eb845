#include "app/import/lenient_json.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "sim/base/error.h"
#include "sim/base/quoted.h"

namespace limberg {
namespace {

class LenientReader {
 public:
  LenientReader(std::string_view text, const std::string& file, std::vector<std::string>* mended)
      : text_(text), file_(file), mended_(mended) {}

  LenientJson run() {
    if (text_.size() > LenientJsonLimits::file_bytes) fail("the file is larger than 16 MB");
    if (text_.substr(0, 3) == "\xEF\xBB\xBF") at_ = 3;
    LenientJson root = value(0);
    blanks();
    if (at_ < text_.size()) fail("something follows the end of the JSON");
    return root;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError(file_, line_, what); }

  void blanks() {
    for (; at_ < text_.size(); ++at_) {
      const char c = text_[at_];
      if (c == '\n')
        ++line_;
      else if (c != ' ' && c != '\t' && c != '\r')
        break;
    }
  }
  char peek() {
    blanks();
    if (at_ == text_.size()) fail("broken JSON: the file ends in the middle of it");
    return text_[at_];
  }

  LenientJson value(int depth) {
    if (depth > LenientJsonLimits::depth) fail("broken JSON: nested too deeply");
    if (++values_ > LenientJsonLimits::values) fail("the file holds more than 2 million values");
    LenientJson v;
    const char c = peek();
    v.line = line_;
    if (c == '{' || c == '[') {
      v.kind = c == '{' ? LenientJson::Kind::object : LenientJson::Kind::list;
      entries(v, c == '{' ? '}' : ']', depth);
    } else if (c == '"') {
      v.kind = LenientJson::Kind::text;
      v.text = quoted_text();
    } else if (c == '-' || (c >= '0' && c <= '9')) {
      v.kind = LenientJson::Kind::number;
      v.number = real();
    } else {
      word(v);
    }
    return v;
  }

  void entries(LenientJson& v, char close, int depth) {
    ++at_;
    bool comma = true;  // what stands before the next entry
    for (char c = peek(); c != close; c = peek()) {
      if (c == ',') {
        if (comma) fail("broken JSON: a comma without a value before it");
        comma = true, ++at_;
        continue;
      }
      if (!comma) {
        if (c != '{' && c != '[' && c != '"') fail("broken JSON; expected a comma between two values");
        if (mended_ && mended_->size() < 100)
          mended_->push_back(fmt::format("{}:{}: a comma is missing before this line's value", file_, line_));
      }
      if (close == '}') {
        if (c != '"') fail("broken JSON; expected the name of a value in quotation marks");
        v.key.push_back(quoted_text());
        if (peek() != ':') fail("broken JSON; expected a colon after a value's name");
        ++at_;
      }
      v.item.push_back(value(depth + 1));
      comma = false;
    }
    ++at_;
  }

  std::string quoted_text() {
    std::string out;
    for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_) {
      char c = text_[at_];
      if (static_cast<unsigned char>(c) < ' ') fail("broken JSON: a text goes on over the end of its line");
      if (c != '\\') {
        out.push_back(c);
        continue;
      }
      if (++at_ == text_.size()) break;
      c = text_[at_];
      constexpr std::string_view kFrom = "\"\\/bfnrt", kTo = "\"\\/\b\f\n\r\t";
      if (const size_t k = kFrom.find(c); k != std::string_view::npos) {
        out.push_back(kTo[k]);
      } else if (c == 'u' && at_ + 4 < text_.size()) {  // names of files and keys: ASCII is all that occurs
        unsigned code = 0;
        const auto [end, ec] = std::from_chars(text_.data() + at_ + 1, text_.data() + at_ + 5, code, 16);
        if (ec != std::errc() || end != text_.data() + at_ + 5) fail("broken JSON: a broken \\u in a text");
        out.push_back(code >= ' ' && code < 127 ? char(code) : '?');
        at_ += 4;
      } else {
        fail("broken JSON: an unknown escape in a text");
      }
    }
    if (at_ >= text_.size()) fail("broken JSON: a text does not end");
    ++at_;
    return out;
  }

  double real() {
    double v = 0;
    const auto [end, ec] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), v);
    if (ec != std::errc() || !std::isfinite(v)) fail("a number that cannot be used; expected a finite one");
    at_ = size_t(end - text_.data());
    return v;
  }

  void word(LenientJson& v) {
    const auto take = [&](std::string_view w) {
      if (text_.substr(at_, w.size()) != w) return false;
      at_ += w.size();
      return true;
    };
    if (take("true"))
      v.kind = LenientJson::Kind::boolean, v.truth = true;
    else if (take("false"))
      v.kind = LenientJson::Kind::boolean;
    else if (!take("null"))
      fail("broken JSON at " + limberg::quoted(text_.substr(at_, 12)) + "; expected a value");
  }

  std::string_view text_;
  const std::string& file_;
  std::vector<std::string>* mended_;
  size_t at_ = 0, values_ = 0;
  int line_ = 1;
};

}  // namespace

const LenientJson* LenientJson::find(std::string_view name) const {
  const LenientJson* found = nullptr;
  for (size_t i = 0; i < key.size(); ++i)
    if (key[i] == name) found = &item[i];
  return found;
}

const char* kind_words(LenientJson::Kind kind) {
  switch (kind) {
    case LenientJson::Kind::null:
      return "null";
    case LenientJson::Kind::boolean:
      return "true or false";
    case LenientJson::Kind::number:
      return "a number";
    case LenientJson::Kind::text:
      return "a text";
    case LenientJson::Kind::list:
      return "a list";
    case LenientJson::Kind::object:
      return "an object";
  }
  return "";
}

LenientJson parse_lenient_json(std::string_view text, const std::string& file, std::vector<std::string>* mended) {
  return LenientReader(text, file, mended).run();
}

}  // namespace limberg
