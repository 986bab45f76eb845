// Every row of the table is read, written, limited, described and told: a new act is tested by being in the table.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>
#include <set>

#include "app/program/places.h"
#include "sim/base/error.h"
#include "sim/commands/actions.h"
#include "sim/commands/kinds.h"
#include "sim/commands/script.h"
#include "sim/commands/table.h"
#include "sim/commands/words.h"

namespace limberg {
namespace test_table {

using Json = nlohmann::ordered_json;

/// Fills the fields of a command with random values within their limits.
class Filler {
 public:
  explicit Filler(uint64_t seed) : rng_(seed) {}

  double between(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(rng_); }
  bool coin() { return rng_() % 2 == 0; }

  void operator()(const Field& f, double& v) {
    if (f.key == std::string_view("slack_mm")) return;  // only of a running suture
    // Small spacings on long paths are refused together.
    v = f.key == std::string_view("spacing_mm") ? between(2, 9) : between(f.from, f.to);
    if (coin()) v = std::round(v);
    if ((f.above && v <= f.from) || v < f.from) v = f.to;
  }
  void operator()(const Field& f, int& v) { v = std::uniform_int_distribution<int>(int(f.from), int(f.to))(rng_); }
  void operator()(const Field&, bool& v) { v = coin(); }
  void operator()(const Field& f, std::string& v) {
    const std::string all = "a \"b\" \\ \n\t\xc3\xa9";
    v = coin() ? all : std::string(f.bytes, 'x');
  }
  template <class E>
  requires std::is_enum_v<E>
  void operator()(const Field& f, E& v) { v = E(rng_() % f.names.size()); }
  void operator()(const Field&, ChartPoint& v) { v = {coordinate(), coordinate()}; }
  void operator()(const Field& f, Vec3& v) {
    const std::string_view key = f.key;
    if (key == "rotation_deg")
      v = {between(-200, 200), 0, between(-200, 200)};
    else
      v = {coordinate(), coordinate(), key == "normal" ? 1 : coordinate()};
  }
  template <class P>
  void operator()(const Field& f, std::vector<P>& v) {
    v.resize(size_t(f.from) + rng_() % 6);
    for (P& p : v)
      for (Eigen::Index i = 0; i < p.size(); ++i) p[i] = between(-100, 100);
  }
  void operator()(const Field&, StitchPick& v) {
    v = coin() ? StitchPick{1 + int(rng_() % 1000), {0, 0}} : StitchPick{0, {coordinate(), coordinate()}};
  }
  void operator()(const Field&, FragmentPick& v) {
    v = coin() ? FragmentPick{int(rng_() % 1000), Vec3::Zero()} : FragmentPick{-1, {coordinate(), 0, -0.0}};
  }
  template <class T>
  void operator()(const Field& f, std::optional<T>& v) {
    if (coin()) (*this)(f, v.emplace());
  }
  bool form(const char*, bool, const char*, const char*) { return coin(); }
  template <class T>
  void same_unless_given(const T&, const T&) {}

 private:
  double coordinate() { return between(-1, 1) * std::pow(10., 4 - double(rng_() % 20)); }
  std::mt19937_64 rng_;
};

/// The fields of a command, as one text: equal texts, equal commands.
struct Dump {
  std::string text;
  template <class T>
  void operator()(const Field& f, const T& v) {
    text += std::string(f.key) + "=";
    if constexpr (std::is_enum_v<T>)
      add(double(v));
    else if constexpr (requires { v.has_value(); })
      v ? (*this)(f, *v) : void(text += "none");
    else if constexpr (std::is_same_v<T, std::string>)
      text += v;
    else if constexpr (std::is_arithmetic_v<T>)
      add(double(v));
    else if constexpr (std::is_same_v<T, StitchPick>)
      add(v.id), add(v.at);
    else if constexpr (std::is_same_v<T, FragmentPick>)
      add(v.id), add(v.at_mm);
    else if constexpr (requires { v.data(), v.x(); })
      add(v);
    else
      for (const auto& p : v) add(p);
    text += ";";
  }
  bool form(const char*, bool chosen, const char*, const char*) { return chosen; }
  template <class T>
  void same_unless_given(const T&, const T&) {}

 private:
  void add(double v) { text += fmt::format("{},", v); }
  template <class D>
  void add(const Eigen::MatrixBase<D>& v) {
    for (Eigen::Index i = 0; i < v.size(); ++i) add(double(v[i]));
  }
};

std::string dump(const Command& c) {
  Dump d;
  visit_act(c, [&]<class C>(const C& act) { Act<C>::fields(d, act); });
  return d.text;
}

std::string refusal(const std::string& line) {
  try {
    parse_command(line, "s.jsonl", 7);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(Table, EveryCommandSurvivesItsLine) {
  Filler fill(5);
  std::set<std::string> acts;
  for (int n = 0; n < 300; ++n)
    for_each_act([&]<class C>(std::type_identity<C>) {
      C c{};
      Act<C>::fields(fill, c);
      if constexpr (std::is_same_v<C, CutThrough>) c.normals.resize(c.path.size(), Vec3::UnitZ());
      Command command;
      if constexpr (std::is_constructible_v<HeadCommand, C>)
        command = HeadCommand(c);
      else
        command = c;
      const std::string line = to_json_line(command);
      const Command back = parse_command(line, "s", 1);
      EXPECT_EQ(dump(back), dump(command)) << line;
      EXPECT_EQ(to_json_line(back), line);
      EXPECT_STREQ(action_name(back), Act<C>::name);
      EXPECT_FALSE(in_words(back).empty());
      acts.insert(in_words(back).substr(0, 9));
    });
  EXPECT_GT(acts.size(), 15u);  // the words tell them apart
}

TEST(Table, EveryLimitIsKeptAndNamed) {
  int limits = 0;
  for (const ActionLine& a : action_lines()) {
    const std::string with = a.name + a.form;
    ASSERT_EQ(refusal(a.example), "") << with;
    for (const ActionField& f : a.fields) {
      const std::string key = f.field.key;
      // An example of this kind of line that has the field, in its form.
      Json good = Json::parse(a.example);
      const bool in_form = std::any_of(a.fields.begin(), a.fields.end(),
                                       [&](const ActionField& g) { return good.contains(g.field.key); }) ||
                           a.fields.empty();
      bool other_form = !in_form;
      for (const auto& [k, v] : good.items())
        other_form |= k != "action" && std::none_of(a.fields.begin(), a.fields.end(),
                                                    [&](const ActionField& g) { return g.field.key == k; });
      if (other_form) continue;  // the example is of the action's other kind of line
      const auto expect = [&](const Json& value, const std::string& word) {
        Json bad = good;
        bad[key] = value;
        const std::string why = refusal(bad.dump());
        EXPECT_NE(why.find("s.jsonl:7: "), std::string::npos) << with << ": accepted " << bad.dump();
        EXPECT_NE(why.find("\"" + key + "\""), std::string::npos) << why;
        EXPECT_NE(why.find(word), std::string::npos) << with << " said: " << why << "\n  expected: " << word;
        ++limits;
      };
      if (f.kind == "number" || f.kind == "whole number") {
        const bool whole = f.kind == "whole number";
        const double over = f.field.to * 2 + 1, under = f.field.above ? f.field.from : f.field.from - 1;
        const std::string most = whole ? std::to_string(int64_t(f.field.to)) : fmt::format("{:g}", f.field.to);
        expect(whole ? Json(int64_t(over)) : Json(over), "to " + most);
        expect(whole ? Json(int64_t(under)) : Json(under),
               fmt::format("{} {:g}", f.field.above ? "above" : "from", f.field.from));
        expect("x", "expected");
      } else if (f.kind == "text") {
        expect(std::string(f.field.bytes + 1, 'x'), fmt::format("longer than {} bytes", f.field.bytes));
        expect("", "is empty");
      } else if (f.kind == "choice") {
        expect("moon", "expected " + f.limits);
      } else if (f.kind == "true or false") {
        expect(1, "neither true nor false");
      } else if (f.kind.starts_with("p") && f.kind.find("...") != std::string::npos) {
        expect(Json::array(), fmt::format("expected {:g} to", f.field.from));
        expect(3, "list of points");
      } else {
        expect(Json::array({1, 2, 3, 4}), "expected");
        expect(Json::array({1e9, 0, 0}), "");
      }
      if (f.field.stands == Stands::always) {
        Json bad = good;
        bad.erase(key);
        EXPECT_NE(refusal(bad.dump()), "") << with << " without " << key;
      }
    }
    Json more = Json::parse(a.example);
    more["colour"] = 1;
    EXPECT_NE(refusal(more.dump()).find("unknown key \"colour\""), std::string::npos);
  }
  EXPECT_GT(limits, 120);
}

TEST(Table, EveryActIsDescribed) {
  const std::string text = actions_text(), page = actions_markdown();
  for_each_act([&]<class C>(std::type_identity<C>) {
    for (const std::string& t : {text, page}) {
      EXPECT_NE(t.find(Act<C>::name), std::string::npos) << Act<C>::name;
      EXPECT_NE(t.find(Act<C>::help), std::string::npos) << Act<C>::name;
      EXPECT_NE(t.find(Act<C>::example), std::string::npos) << Act<C>::name;
    }
    EXPECT_NE(refusal("{\"action\":\"dance\"}").find(Act<C>::name), std::string::npos);
    EXPECT_EQ(to_json_line(parse_command(Act<C>::example, "e", 1)).substr(0, 11), "{\"action\":\"");
  });
  for (const ActionLine& a : action_lines())
    for (const ActionField& f : a.fields) {
      EXPECT_NE(page.find("`" + std::string(f.field.key) + "`"), std::string::npos) << a.name;
      EXPECT_GT(std::string_view(f.field.help).size(), 2u) << a.name << "." << f.field.key;
      if (f.field.usual_to > 0) {
        EXPECT_GE(f.field.usual_from, f.field.from) << a.name << "." << f.field.key;
        EXPECT_LE(f.field.usual_to, f.field.to) << a.name << "." << f.field.key;
      }
    }
  EXPECT_EQ(action_field("incise", "angle_deg").limits, "20 to 160");
  EXPECT_THROW(action_field("incise", "colour"), std::logic_error);
  EXPECT_EQ(actions_text("dance"), "");
}

TEST(Table, ActsHaveKinds) {
  std::string cutting, sewing, looking_back, leaving;
  for_each_act([&]<class C>(std::type_identity<C>) {
    Command c;
    if constexpr (std::is_constructible_v<HeadCommand, C>)
      c = HeadCommand(C{});
    else
      c = C{};
    const std::string name = std::string(Act<C>::name) + " ";
    if (cuts_skin(c)) cutting += name;
    if (sews(c)) sewing += name;
    if (looks_back(c)) looking_back += name;
    if (leaves_patient(c)) leaving += name;
  });
  EXPECT_EQ(cutting, "incise incise undermine excise redo excise cut_through ");
  EXPECT_EQ(sewing, "suture suture_row suture_corner suture_between suture_bite ");
  EXPECT_EQ(looking_back, "undo redo suture_between cut_suture suture_bite suture_tie suture_let_go ");
  EXPECT_EQ(leaving, "stage wait shown mark ");
}

TEST(Table, ThePageIsMadeFromIt) {
  std::ifstream in(source_dir() + "/docs/actions.md", std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  EXPECT_EQ(text, actions_markdown()) << "renew with: build/limberg actions --markdown > docs/actions.md";
}

TEST(Table, PythonsStubsNameItsFields) {
  std::ifstream in(source_dir() + "/library/python/__init__.pyi");
  std::map<std::string, std::set<std::string>> written, wanted;
  const std::regex argument(R"((\*{0,2}\w+): \w)");
  bool made = false;
  for (std::string line; std::getline(in, line);) {
    made = made || line.rfind("# Actions of a script", 0) == 0;
    if (!made || line.rfind("def ", 0) != 0) continue;
    std::set<std::string>& of = written[line.substr(4, line.find('(') - 4)];
    for (std::sregex_iterator m(line.begin(), line.end(), argument), end; m != end; ++m)
      if (const std::string name = (*m)[1]; name[0] != '*') of.insert(name);
  }
  for (const ActionLine& a : action_lines()) {
    std::set<std::string>& of = wanted[a.name];
    for (const ActionField& f : a.fields)
      if (const std::string key(f.field.key); key != "from" && key != "with") of.insert(key);
  }
  EXPECT_EQ(written, wanted) << "renew with library/python/stubs.py, and Python's module built anew";
}

TEST(Words, AStoryTellsCutsThenCountsTheRest) {
  const std::vector<ChartPoint> square{{0, 0}, {20, 0}, {20, 10}, {0, 10}};
  EXPECT_EQ(story_of({Excise{square, 4}, Incise{{{0, 0}, {3, 4}, {3, 14}}, 5, 60}}),
            "Excision of 200 mm², 4 mm deep. Incision of 15 mm, 5 mm deep, blade at 60°.");
  EXPECT_EQ(story_of({SetHook{1, {0, 0}}, SetHook{2, {1, 0}}, MoveHook{1}, MoveHook{2}, SutureRow{}, Stage{"x"}}),
            "2 hooks set. The flap is moved with the hooks. One row of sutures.");
  EXPECT_EQ(story_of({Suture{}, SutureCorner{}, ReleaseHook{1}}), "2 key sutures. The hooks are taken out.");
  // Pieces of one stroke are one incision.
  EXPECT_EQ(story_of({InciseMore{1, {{0, 0}, {5, 0}}, 4, 90, false}, InciseMore{1, {{9, 0}}, 4, 90, true}}),
            "Incision of 9 mm, 4 mm deep.");
  EXPECT_EQ(story_of({}), "");
}

TEST(Words, AStoryTellsWhatAHandCutNotHowOftenItWasLifted) {
  const auto cut = [](double from, double to, double deep = 4) { return Incise{{{from, 0}, {to, 0}}, deep}; };
  // A hand that is lifted on the way goes on with the same cut.
  std::vector<Command> pieces;
  for (int k = 0; k < 7; ++k) {
    pieces.push_back(cut(5.2 * k + 0.1, 5.2 * k + 5.2));
    pieces.push_back(cut(5.2 * k + 5.2, 5.2 * k + 5.2));  // of no length
  }
  EXPECT_EQ(story_of(pieces), "Incision of 36.3 mm, 4 mm deep.");
  EXPECT_EQ(story_of({cut(0, 10), cut(11, 20)}), "2 incisions of 10 and 9 mm, 4 mm deep.");
  EXPECT_EQ(story_of({cut(0, 10), cut(10, 20, 6)}), "Incision of 10 mm, 4 mm deep. Incision of 10 mm, 6 mm deep.");
  EXPECT_EQ(story_of({cut(0, 10), cut(20, 30), cut(40, 50), cut(60, 70), cut(80, 90)}),
            "5 incisions of 50 mm together, 4 mm deep.");
  EXPECT_EQ(story_of({cut(3, 3)}), "");
  // What was taken back was not done.
  EXPECT_EQ(story_of({cut(0, 10), Undo{}, cut(0, 20)}), "Incision of 20 mm, 4 mm deep. One action taken back.");
}

TEST(Words, ATitleSaysWhichActsStand) {
  const std::vector<ChartPoint> square{{0, 0}, {20, 0}, {20, 10}, {0, 10}};
  const auto title = [](const std::vector<Command>& acts) { return title_of_acts(acts); };
  EXPECT_EQ(
      title({Excise{square, 4}, Stage{"x"}, Incise{{{0, 0}, {3, 4}}, 5}, SetHook{1, {0, 0}}, Suture{}, SutureRow{}}),
      "Excision, incision and sutures");
  EXPECT_EQ(title({Excise{square, 4}, Undo{}, Undermine{square, 4}}), "Undermining");
  EXPECT_EQ(title({SetHook{1, {0, 0}}, Stage{"x"}}), "");
  EXPECT_EQ(title({HeadCommand(CutBone{}), HeadCommand(MoveFragment{})}), "Osteotomy and fragments moved");
}

TEST(Words, NumbersAreRoundedToTheirFirstDigits) {
  EXPECT_EQ(rounded_text(1234.5, 3), "1230");
  EXPECT_EQ(rounded_text(0.04567, 2), "0.046");
  EXPECT_EQ(rounded_text(4, 3), "4");
  EXPECT_EQ(rounded_text(346.41, 3), "346");
  EXPECT_EQ(rounded_text(9.999, 3), "10");
  EXPECT_EQ(rounded_text(0, 3), "0");
}

}  // namespace test_table
}  // namespace limberg
