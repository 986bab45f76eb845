#pragma once
// A headset as the program has it: frames to be drawn for two eyes, and where head and hands are. OpenXR is behind it,
// in a part of its own (openxr/openxr_part.cpp), so that nothing else is linked to its loader.
//
// Two threads use it. One draws: it makes the session, calls step() again and again with its GL context current, and
// lets the session go. Another one may read() meanwhile; it has ended before the session does.
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "app/headset/room_pose.h"
#include "render/gl_context.h"
#include "render/headset.h"

namespace limberg {

struct HeadsetFacts {
  std::string runtime, system;  // their names
  int width = 0, height = 0;    // of an eye's picture, pixels
  bool floor = false;           // y = 0 of the room is the floor
  bool hands = false;           // it sees fingers
  std::string context;          // by which pictures are handed over: "EGL" or "GLX"
};

struct HeadsetEye {
  RoomPose pose;
  EyeAngles angles;
};

/// A frame that the runtime asks for, with eyes as they will be when it is seen.
struct HeadsetFrame {
  int64_t seen_ns = 0, period_ns = 0;  // on the runtime's clock
  RoomPose head;                       // between the eyes
  std::array<HeadsetEye, 2> eye;       // left, right
};

class HeadsetPainter {
 public:
  virtual ~HeadsetPainter() = default;
  /// False: there is nothing to be seen yet; the eyes are not asked for.
  virtual bool begin(const HeadsetFrame& frame) = 0;
  /// Into a texture of the context that is current; its lowest row comes first.
  virtual void eye(int which, unsigned texture, int width, int height) = 0;
};

struct HandReading {
  // A controller in the hand: it looks along -z of its pose.
  bool controller = false;
  RoomPose aim;
  bool press = false, clutch = false, place = false;  // trigger, grip, menu
  // The hand itself, as cameras see it: finger tips, which look along -z.
  bool fingers = false;
  RoomPose forefinger, thumb;
};

/// All at one moment, of CLOCK_MONOTONIC.
struct HandsReading {
  int64_t at_ns = 0;
  std::array<HandReading, 2> hand;  // left, right
};

class HeadsetSession {
 public:
  virtual ~HeadsetSession() = default;
  virtual const HeadsetFacts& facts() const = 0;

  enum class Step { idle, frame, ended };
  /// Takes what the runtime has to say and does one frame, for which it waits. idle: it wants none now, ask again
  /// soon. ended: it asked the session to end, or end() did. RenderUnavailable: it has lost the session.
  virtual Step step(HeadsetPainter& painter) = 0;
  /// Asks for the end, which step() then brings.
  virtual void end() = 0;

  /// Where the hands are now. False: nobody wears the headset, or another program has the hands.
  virtual bool read(HandsReading& reading) = 0;
};

/// Makes a context of this kind and current; whoever opens the session keeps it until that has ended.
using MakeContext = std::function<NativeContext(NativeContext::Kind)>;

/// RenderUnavailable says why there is none: built without OpenXR, no runtime, no headset, no graphics that it takes.
std::unique_ptr<HeadsetSession> open_headset(const MakeContext& make_context);

/// The file that says which runtime there is (XR_RUNTIME_JSON, or where OpenXR's loader looks); empty: none. Asking a
/// runtime itself may start it.
std::string headset_runtime_file();

}  // namespace limberg
