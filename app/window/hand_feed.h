#pragma once
// What passes between main, render and device thread of a session with a window.
//
//   main ──ring: everything that the person does to the patient, in its order──► device  (PointerSource)
//   main ──Screen::events: every event of the window──────────────────────────► render  (WindowFrames)
//   render ──ring: what panels have chosen, and how far they have come────────► main    (InputRouter)
//   render ──triple buffer: the frame that the person sees────────────────────► main
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <variant>

#include "app/session/triple_buffer.h"
#include "app/window/desk_keys.h"
#include "devices/spsc_ring.h"
#include "render/view.h"

namespace limberg {

/// Where the mouse points.
struct PointerReading {
  Vec3f eye_mm = Vec3f::Zero(), towards = -Vec3f::UnitZ();
  float lift_mm = 0;  // of a held hook, towards the eye
  int32_t pressed = 0;
  int32_t inside = 1;  // 0: the pointer is over a panel or outside
};

/// One thing that is done to the patient: the mouse, a choice, a command of a panel, or a reading of the hand that
/// shows a step. Times and numbers of samples are set by whoever hands them on.
using HandInput = std::variant<PointerReading, ControlSample, StylusSample, CommandSample>;

/// What is to be shown by an emulated hand: so many acts are taken back, then these are done. Without acts that is all.
struct ShowActs {
  int undos = 0;
  std::shared_ptr<const std::vector<Command>> acts;  // null: none
};
/// What panels may ask for: a tool, another control, a command, to be shown something.
using PanelAnswer = std::variant<HandChoice, ControlSample, ShowActs, CommandSample>;

/// A rectangle of the frame, in pixels.
struct FrameRect {
  float x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool holds(float x, float y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
};

/// A frame as the person sees it: from where, and what panels cover.
struct FrameSeen {
  View view;
  int width = 1, height = 1;
  std::array<FrameRect, 12> panel;  // all that can be open at once
  size_t panels = 0;
  bool popup = false;   // a list is open: the next click is its, wherever it goes
  bool typing = false;  // a text field has the keys
  bool tour = false;    // the tour is open: Enter and Esc are its
  bool asks = false;    // for a place: a click on the patient answers, whatever tool the mouse has
  bool on_panel(float x, float y) const {
    for (size_t i = 0; i < panels; ++i)
      if (panel[i].holds(x, y)) return true;
    return popup;
  }
};

struct HandFeed {
  SpscRing<HandInput> input{1 << 12};       // main -> device
  SpscRing<PanelAnswer> answers{1 << 8};    // render -> main
  std::atomic<uint64_t> answered{0};        // render -> main: the number of the last event whose answers are there
  TripleBuffer<FrameSeen> seen;             // render -> main
  std::atomic<bool> keep_recording{false};  // render -> main
  std::atomic<bool> showing{false};         // main -> render, device: something is being shown
};

}  // namespace limberg
