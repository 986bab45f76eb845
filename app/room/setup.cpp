#include "app/room/setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>

#include "app/program/interrupt.h"
#include "app/session/clock.h"

namespace limberg {
namespace {

enum class Answer { go_on, leave_out, back, quit };

/// What the person types; Enter goes on. An end of the answers is `at_end`.
Answer ask(const RoomTalk& talk, const std::string& question, Answer at_end) {
  talk.out << question << std::flush;
  for (std::string line; !interrupted() && std::getline(talk.in, line);) {
    line.erase(0, line.find_first_not_of(" \t\r"));
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (line.empty() || line == "y" || line == "yes") return Answer::go_on;
    if (line == "s" || line == "skip") return Answer::leave_out;
    if (line == "b" || line == "back") return Answer::back;
    if (line == "q" || line == "quit") return Answer::quit;
    talk.out << "  " << talk.w("Enter goes on, s leaves the step out, b does the step before once more, q ends:") << " "
             << std::flush;
  }
  talk.out << "\n";
  return interrupted() ? Answer::quit : at_end;
}

/// Lines of at most so many letters.
std::string wrapped(const std::string& words, const std::string& indent) {
  constexpr size_t kWide = 92;
  std::string out = indent, line;
  for (size_t at = 0; at < words.size();) {
    const size_t blank = std::min(words.find(' ', at), words.size());
    const std::string word = words.substr(at, blank - at);
    if (!line.empty() && line.size() + 1 + word.size() > kWide) out += line + "\n" + indent, line.clear();
    line += (line.empty() ? "" : " ") + word;
    at = blank + 1;
  }
  return out + line;
}

void count_down(const RoomTalk& talk) {
  const RealClock clock(RealClock::monotonic_ns());
  for (int s = 3; s > 0 && !interrupted(); --s) {
    talk.out << "  " << s << " ..." << std::flush;
    clock.sleep_until_ns((4 - s) * 1000 * kNsPerMs);
  }
  talk.out << "\n";
}

void replace_checks(SetUpOutcome& o, const std::string& step, const std::vector<RoomCheck>& by) {
  std::erase_if(o.checks, [&](const RoomCheck& c) { return c.step == step; });
  o.checks.insert(o.checks.end(), by.begin(), by.end());
}

}  // namespace

std::string in_words(const RoomCheck& c, const Words& w) {
  const std::string unit = c.unit.empty() ? "" : " " + c.unit;
  const std::string value = w("{:>8.3g}", c.value + 0.0), limit = w("{:.3g}", c.limit);
  return fmt::format("{:<5} {:<44} {}{}, {} {}", c.good() ? w("good") : w("BAD"), w.said(c.what), value, unit,
                     c.at_most ? w("at most") : w("at least"), limit);
}

SetUpOutcome set_up(RoomHands& hands, const RoomTalk& talk, const Calibration& from, bool check_only) {
  SetUpOutcome o;
  o.calibration = from;
  const Words& w = talk.w;
  talk.out << w("Listening for what is there ...") << "\n" << std::flush;
  HeardDevices heard = heard_in(hands.during("look", 2, {}, {}));
  heard.tracked = hands.tracked();
  for (const std::string& line : hands.health()) talk.out << "  " << line << "\n";
  talk.out << "  "
           << w("heard: {}", heard.stylus && heard.glove ? w("a stylus and a glove")
                             : heard.stylus              ? w("a stylus")
                             : heard.glove               ? w("a glove")
                                                         : w("nothing yet"))
           << "\n";
  std::vector<RoomStep> steps = room_steps(heard);
  if (check_only) std::erase_if(steps, [](const RoomStep& s) { return s.calibrates; });
  // Where no answer comes any more an emulated hand goes on, and tries as often as one that nobody is asked for.
  constexpr int kTriesUnasked = 3;
  double minutes = 0;
  for (const RoomStep& s : steps) minutes += (s.seconds + 20) / 60;
  talk.out << w("{} steps, about {:.0f} minutes. Enter begins a step, s leaves it out, b does the one before once "
                "more, q ends.",
                steps.size(), std::max(1.0, minutes))
           << "\n";

  constexpr int kMostTries = 20;
  std::map<std::string, Calibration> before;  // each step
  std::map<std::string, bool> good;
  int tries = 0;
  for (size_t i = 0; i < steps.size() && !o.ended;) {
    const RoomStep& s = steps[i];
    if (tries == 0) {
      talk.out << "\n"
               << w("Step {} of {}: {}", i + 1, steps.size(), w(s.title)) << "\n"
               << wrapped(w(s.ask), "  ") << "\n"
               << wrapped(w(s.why), "  ") << "\n";
      before[s.name] = o.calibration;
    }
    const Answer unasked = tries < kTriesUnasked ? Answer::go_on : Answer::leave_out;
    const Answer answer =
        talk.waits ? ask(talk, fmt::format("  {} ", tries == 0 ? w("Ready? [Enter]") : w("Once more? [Enter, or s]")),
                         hands.emulated() ? unasked : Answer::quit)
        : interrupted() ? Answer::quit
                        : unasked;
    if (answer == Answer::quit || tries >= kMostTries) {
      o.ended = true;
      break;
    }
    if (answer == Answer::back && i > 0) {
      --i, tries = 0;
      o.calibration = before[steps[i].name];
      continue;
    }
    if (answer == Answer::leave_out) {
      talk.out << "  " << w("left out") << "\n";
      ++i, tries = 0;
      continue;
    }
    if (!talk.waits && !hands.emulated()) count_down(talk);
    talk.out << "  " << w("Now ...") << "\n" << std::flush;
    int told_s = 0;
    const std::vector<Sample> samples = hands.during(
        s.name, s.seconds,
        [&](const std::vector<Sample>& so_far) { return s.presses > 0 && presses_in(so_far) >= s.presses; },
        [&](double t) {
          if (hands.emulated() || int(t) / 5 <= told_s / 5) return;
          told_s = int(t);
          talk.out << "  " << w("{:.0f} s of {:.0f}", t, s.seconds) << "\n" << std::flush;
        });
    if (interrupted()) {
      o.ended = true;
      break;
    }
    o.heard[s.name] = samples;
    Calibration c = before[s.name];
    const StepOutcome outcome = s.judge(samples, s.seconds, c);
    for (const RoomCheck& k : outcome.checks) talk.out << "  " << in_words(k, w) << "\n";
    replace_checks(o, s.name, outcome.checks);
    good[s.name] = outcome.good();
    if (outcome.good()) {
      o.calibration = c;
      o.calibrated |= s.calibrates;
      ++i, tries = 0;
      continue;
    }
    ++tries;
    const std::string why = outcome.advice.empty() ? w("see above") : w.said(outcome.advice);
    talk.out << wrapped(w("Not good: {}.", why), "  ") << "\n";
  }
  o.usable = !steps.empty();
  for (const RoomStep& s : steps) {
    if (good[s.name]) continue;
    o.not_good.push_back(s.title);
    if (s.calibrates) o.usable = false;
  }
  if (heard.tracked && !heard.stylus && !heard.glove) o.usable = false;  // a tracker that sends nothing
  return o;
}

}  // namespace limberg
