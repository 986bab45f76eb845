#pragma once
// One of a class: what a student's operation (or the expert's) came to, as it was measured. It is the result.json of a
// session with what only a class asks for beside it, under `class`: the way of the tool over the patient, when each act
// was done, where presses came to nothing, where each stitch lies. A folder of a session has the first part alone.
//
// Nothing here judges: findings.h does, against the lesson's plan.
#include <string>
#include <vector>

#include "app/report/report_data.h"

namespace limberg {

/// The way of the tool, in mm on the skin at rest (of bones: on the picture's plane). tool: of a pressed tool its
/// number (devices/sample.h), 0 between; a gap is not a number in all three.
struct ClassPath {
  std::vector<double> x_mm, y_mm, tool;
  bool empty() const { return x_mm.empty(); }
};
void fields(ClassPath& p, auto&& f) { f("x_mm", p.x_mm), f("y_mm", p.y_mm), f("tool", p.tool); }

/// Presses that came to nothing. at: no number where there is no place.
struct ClassMissed {
  std::vector<std::string> why;
  std::vector<double> x_mm, y_mm;
};
void fields(ClassMissed& m, auto&& f) { f("why", m.why), f("x_mm", m.x_mm), f("y_mm", m.y_mm); }

/// Where each stitch of metrics/sutures lies on the skin at rest, in their order.
struct ClassStitches {
  std::vector<double> x_mm, y_mm;
};
void fields(ClassStitches& s, auto&& f) { f("x_mm", s.x_mm), f("y_mm", s.y_mm); }

/// act_s: when each line of the result's script was done, in s of the session. whole: it ended as a session ends.
struct ClassExtra {
  static constexpr int kFormat = 4;  // of what is kept of a measurement
  std::string kind;                  // "recording", "script", "result"
  MaybeFlag whole;
  std::string damage;  // of a recording, in words
  ClassPath path;
  ClassMissed missed;
  ClassStitches stitches;
  std::vector<double> act_s;
};
void fields(ClassExtra& x, auto&& f) {
  f("kind", x.kind), f("whole", x.whole), f("damage", x.damage), f("path", x.path), f("missed", x.missed);
  f("stitches", x.stitches), f("act_s", x.act_s);
}

struct ClassMember {
  std::string name;     // that the page shows: a pseudonym, or the file's
  std::string picture;  // of the result, a file; empty: none
  ReportData result;
  ClassExtra also;
};

/// From the text of a result; what is absent stays empty, lists of different lengths are cut to the shortest.
/// InputError (`file`) as read_report_data.
ClassMember read_member(const std::string& text, const std::string& file);

/// A figure of `exercise` ("time_s", "design/corner_max_mm"), if it is there.
Maybe exercise_of(const ReportData& result, const char* name);

/// A name for a content: two pronounceable words made of its hash (Wilkerson's proquints, arXiv:0901.4016), the same
/// whatever else lies in the folder.
std::string pseudonym(uint64_t content);

}  // namespace limberg
