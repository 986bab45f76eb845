#pragma once
// Sources of a session that goes on where an earlier part of it ended, so that both parts are one recording.
//
//   time     counts on from the moment at which it goes on
//   numbers  of a stream that the earlier part had count on
//   stylus   the first one that is moved takes the place of the earlier part's, whatever device it is
//
// When the earlier part was cut off, nobody let go: whatever was pressed is let go first.
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "devices/force/tool_follower.h"
#include "devices/sample.h"
#include "devices/source.h"

namespace limberg {

/// What the sources of the further part have to know of the earlier one, and of each other. All of them are polled by
/// one thread.
class EarlierPart {
 public:
  /// The further part begins at this time of the session. InputError: more streams than a session has.
  EarlierPart(const std::vector<Sample>& samples, int64_t from_ns);
  int64_t from_ns() const { return from_ns_; }
  /// Of the stylus, if it was pressed: the same once more, and let go.
  const std::vector<Sample>& let_go() const { return let_go_; }
  /// Puts a sample whose time counts from zero into the session.
  void put_after(Sample& sample);

 private:
  struct Stream {
    int number = 0;
    int32_t device = 0;
    int64_t last = -1;  // of the earlier part
    int64_t shift = 0;  // of the further one's numbers
    bool goes_on = false;
  };
  Stream* stream(int number, int32_t device);
  static constexpr size_t kMost = 512;
  std::array<Stream, kMost> streams_{};
  size_t n_ = 0;
  int64_t from_ns_ = 0;
  std::optional<int32_t> stylus_, taker_;  // device of the earlier stylus; that which takes its place
  std::vector<Sample> let_go_;
};

class ContinuedSource final : public Source, public ToolFollower, private SampleSink {
 public:
  /// `source` counts its time from zero, which is when the session goes on.
  ContinuedSource(std::unique_ptr<Source> source, std::shared_ptr<EarlierPart> earlier);
  void poll(int64_t now_ns, SampleSink& sink) override;
  void look(const Snapshot& snapshot) override { source_->look(snapshot); }
  void hold(const ToolState& state) override;
  bool done() const override { return source_->done(); }
  SourceCounts counts() const override { return source_->counts(); }
  std::string health() const override { return source_->health(); }

 private:
  void on_sample(const Sample& sample) override;
  std::unique_ptr<Source> source_;
  std::shared_ptr<EarlierPart> earlier_;
  ToolFollower* follower_;
  SampleSink* sink_ = nullptr;  // valid during poll() only
};

}  // namespace limberg
