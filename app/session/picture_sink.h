#pragma once
// The door between the session and whatever makes pictures: the off-screen renderer, a window, or nothing.
//
// All calls come from the render lane's thread. `prepare` comes first, after that thread has lowered its priority and
// before the clock starts: the place to make a GL context, whose helper threads inherit the priority. The snapshot and
// the topology it names stay valid during a call, and the topology until the next call.
#include <string>

#include "app/session/lattice_shown.h"
#include "app/session/notice.h"
#include "devices/tool_event.h"
#include "devices/virtual_hand.h"
#include "sim/patient/snapshot.h"

namespace limberg {

class PictureSink {
 public:
  virtual ~PictureSink() = default;
  virtual void prepare(const SurfaceTopology& first) { (void)first; }
  /// The gloves' hands, before each frame; without a glove they are not valid.
  virtual void second_hand(const SecondHand& hand, const SecondHand& other) { (void)hand, (void)other; }
  /// One frame of the running session.
  virtual void frame(const Snapshot& snapshot, const ToolState& tool) = 0;
  /// The running session looks as it did at the last frame (visible.h): who keeps every frame keeps that one again.
  virtual void same_frame() {}
  /// A named stage of the operation was passed: the picture that goes into the report.
  virtual void stage(const std::string& name, const Snapshot& snapshot) = 0;
  /// After the last frame, on the same thread: the place to let go of a GL context.
  virtual void finish() {}
  /// True when a frame is wanted although neither patient nor hand has changed (a panel was touched, the camera moved).
  virtual bool wants_frame() { return false; }
  /// True when the patient's tension is to be filled in (Snapshot::field), which costs the solver a few ms a step.
  virtual bool wants_field() const { return false; }
  /// True when the lattice is to be shown: then `lattice` comes before each frame.
  virtual bool wants_lattice() const { return false; }
  virtual void lattice(const LatticeShown& lattice) { (void)lattice; }
  /// Something was done, undone or refused (channels.h), in order, before the frame that shows it.
  virtual void notice(const Notice& notice) { (void)notice; }
  /// A press came to nothing; `snapshot`: the patient as it is shown.
  virtual void missed(const MissedPress& press, const Snapshot& snapshot) { (void)press, (void)snapshot; }
  /// False asks the session to end (a window was closed).
  virtual bool open() const { return true; }
};

}  // namespace limberg
