#pragma once
// A FASTRAK on a serial port as a source of samples: a thread of its own reads, writes, and opens the port again and
// again while it is not there; poll() takes readings from a queue and never waits.
#include <memory>
#include <string>

#include "devices/fastrak/link.h"
#include "devices/session_time.h"
#include "devices/source.h"

namespace limberg::fastrak {

struct SourceSettings {
  std::string path = "/dev/ttyS0";
  LinkSettings link;
  bool raw = true;  // bytes are passed on too, so that a recording holds them
  size_t queue = 4096;
};

/// "PATH", "PATH,ft", "PATH,fts,ascii,9600": the stations' roles, the format and the rate of the line in any order
/// after the path. InputError on what cannot be read.
SourceSettings parse_source(const std::string& text);

class FastrakSource final : public Source {
 public:
  /// Never fails: a port that is not there is waited for; health() says why.
  FastrakSource(const SourceSettings& settings, const SourceTime& time);
  ~FastrakSource() override;
  void poll(int64_t now_ns, SampleSink& sink) override;
  bool done() const override { return false; }
  SourceCounts counts() const override;
  std::string health() const override;
  /// The port is looked for here from now on (a USB adapter may come back under another name).
  void look_at(const std::string& path);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg::fastrak
