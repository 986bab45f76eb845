#pragma once
// One member of a study as a file: what it came to, or why it failed, and by which program.
//
// Each member is a job of its own, on this machine or another: `limberg study NAME --set ... --member --out DIR` leaves
// DIR/members/MEMBER.json, whole or not at all. Whoever gathers them finds them by name and takes those that the same
// program made of the same values and inputs.
#include <cstdint>
#include <optional>
#include <string>

#include "app/study/study.h"

namespace limberg::study {

/// "zplasty,angle=60,prestretch=10,cell_mm=5": the name of its files.
std::string member_name(const Family& family, const Values& values);
/// DIR/members/MEMBER + ending (".json", ".png", ".log").
std::string member_file(const std::string& dir, const Family& family, const Values& values, const char* ending);

struct MemberResult {
  Row row;                 // without what is pictured
  std::string failure;     // why there is no row; empty: it is done
  bool cut_short = false;  // failed by a limit or a signal, not in its own words: it may be tried again
  double seconds = 0;      // wall time
  uint64_t program = 0, inputs = 0;
};

/// Hash of the running program's file. InputError when it cannot be read.
uint64_t program_hash();

/// The first line of a log; empty when there is none.
std::string first_line_of(const std::string& file);

std::string member_text(const Family& family, const Values& values, const MemberResult& result);
/// InputError when the file is there but no member of a study, or one of other values.
std::optional<MemberResult> read_member(const std::string& file, const Family& family, const Values& values);

/// The members of a family whose files lie in DIR/members, in the order of their values. InputError when there is no
/// such folder or a file is broken.
std::vector<Values> members_in(const std::string& dir, const Family& family);

}  // namespace limberg::study
