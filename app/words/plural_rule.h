#pragma once
// Which of a language's forms goes with a number: gettext's Plural-Forms, "nplurals=2; plural=(n != 1);".
#include <cstdint>
#include <string>
#include <string_view>

namespace limberg {

class PluralRule {
 public:
  static constexpr int kMostForms = 6;
  PluralRule() = default;  // English: 0 for one, 1 for all others
  /// What is wrong with it is left in `wrong`; the rule is then English.
  PluralRule(std::string_view plural_forms, std::string& wrong);

  int forms() const { return forms_; }
  int form(int64_t n) const;

 private:
  int forms_ = 2;
  std::string expression_ = "n!=1";
};

}  // namespace limberg
