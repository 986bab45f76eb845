#pragma once
// `limberg study` in parts: its options; one member, or one task of a cluster, run here; what has come, gathered.
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "app/commands/commands.h"
#include "app/study/engine.h"
#include "app/study/member_file.h"
#include "app/study/study_result.h"

namespace limberg {

struct StudyOptions {
  std::string name;
  std::vector<std::string> settings, collect;
  int jobs = 0;
  bool check = false, list_jobs = false, member = false;
  std::string engine = "local", task;
  double limit_s = 0;
  int memory_MB = 0, retries = 2, per_task = 0;
  std::vector<std::string> sbatch;
  std::vector<std::string> sample;  // kind and number, or nothing
  std::string ranges = "facial-skin";
  uint64_t seed = 1;
  bool sensitivity = false;
  CommonOptions common;

  study::MemberLimits limits(int workers) const { return {limit_s, memory_MB, workers, common.simd}; }
};

uint64_t inputs_of(const study::Family& family, const study::Values& values);

/// One member, here and now; leaves its file and picture. Whatever goes wrong with it is said in its file.
int run_member(const StudyOptions& o);

/// The members of a task's file that have none yet, one after the other, each a process.
int run_task(const StudyOptions& o);

/// Where the members' files are looked for and left.
struct MemberPlaces {
  std::vector<std::string> look;  // --collect's, or the one folder of this study
  std::string leave;
};

/// Reads what is there and lasts, prints what is new in the order of the members.
class Gathering {
 public:
  /// `print`: each row, on standard output.
  Gathering(std::vector<study::Gathered>& parts, const MemberPlaces& at, bool print)
      : parts_(parts), at_(at), print_(print) {}
  /// `final`: also what lies behind members that are missing.
  void look(bool final);
  using Key = std::pair<size_t, size_t>;  // part, member
  std::set<Key> missing;                  // still to be made
  std::set<Key> given_up;
  std::map<Key, std::string> reason;
  const std::vector<std::string>& pictures() const { return pictures_; }

 private:
  std::vector<study::Gathered>& parts_;
  const MemberPlaces& at_;
  bool print_;
  std::vector<std::string> pictures_;
  size_t part_ = 0, member_ = 0;
  bool head_ = true;
};

}  // namespace limberg
