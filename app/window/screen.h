#pragma once
// Where the window's frames go and its events come from: a real window (glfw_screen.h), or memory in a test.
//
// Events are made on the main thread (input_router.h) and read on the render thread.
#include <atomic>
#include <cstdint>
#include <memory>

#include "devices/spsc_ring.h"
#include "render/gl_context.h"

namespace limberg {

struct WindowEvent {
  enum Kind : int32_t { pointer, button, wheel, key, text };
  enum Key : int32_t {  // besides the capital letters and digits of ASCII
    space = ' ',
    escape = 256,
    enter,
    tab,
    backspace,
    remove,
    arrow_left,
    arrow_right,
    arrow_up,
    arrow_down,
    home,
    end,
    f1,
    question,
    f10,
    page_up,
    page_down
  };
  enum Mods : uint32_t { shift = 1, control = 2, alt = 4 };
  int32_t kind = pointer;
  float x = 0, y = 0;  // pointer: pixels of the frame; wheel: notches
  int32_t code = 0;    // button: 0 left, 1 right, 2 middle; key: Key; text: code point
  int32_t down = 0;
  uint32_t mods = 0;
  // What the InputRouter decided:
  uint64_t number = 0;      // in the order of all events
  bool for_panels = false;  // a button, the wheel: over a panel; a key: a text field has it
  bool for_hand = false;    // a key: the hand has heard it
  bool by_keys = false;     // the mouse's place or button, led by keys
};

class Screen {
 public:
  virtual ~Screen() = default;
  /// A context that draws to this screen; for the thread that asks.
  virtual std::unique_ptr<GlContext> context() = 0;

  SpscRing<WindowEvent> events{1 << 11};
  std::atomic<int> width{1280}, height{720};  // of the frame, pixels
  std::atomic<bool> open{true};
};

}  // namespace limberg
