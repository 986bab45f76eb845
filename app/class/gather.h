#pragma once
// What lies in a teacher's folder, and in the folders below it:
//
//   NAME.lcm         a recording of `run` or `emulate`: one student
//   NAME.jsonl       a script, where it lies neither beside a recording of that name nor beside a result
//   NAME/result.json the folder of a session (run, replay, operate --out), where no recording lies in it
//
// What is broken and what is something else is named with its reason; nothing of it stops the rest.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace limberg {

struct FoundSession {
  enum Kind : uint8_t { recording, script, result } kind = recording;
  std::string path;      // the file; of a result its folder
  std::string scene;     // by name; a script may have none
  uint64_t content = 0;  // hash of the bytes
};
struct LeftOut {
  std::string path, reason;
  bool broken = false;  // it should have been one of a class, and cannot be used
};
struct GatheredSessions {
  std::vector<FoundSession> sessions;  // in the order of their paths
  std::vector<LeftOut> left_out;
};

/// One file or folder as a session. InputError: it is none, or broken.
FoundSession session_at(const std::string& path);

/// `without`: a folder that is passed over (where the page goes). `look`: called before each file is read; false ends
/// the search. InputError: `folder` is no folder, or holds more than 2000 sessions.
GatheredSessions gather(const std::string& folder, const std::string& without, const std::function<bool(size_t)>& look);

}  // namespace limberg
