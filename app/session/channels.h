#pragma once
// Everything that passes between the threads of a session, in one place.
//
//     device ──ring: tool events, never dropped unsaid──► solver
//     device ──ring: presses that came to nothing──────► render
//     device ──triple buffer: where the hand is────────► solver, render
//     solver ──triple buffer: the patient──────────────► device, render, and main while a step is shown
//     solver, device ──the same for a headset's eyes, while there is one
//     solver ──ring: stages passed, acts done──────────► render
//     device ──ring: every sample as received──────────► recorder
//     device, solver ──rings: what they found──────────► recorder (live sessions)
//     solver ──ring: some places of the patient────────► recorder
//     device ◄──triple buffers: how stiff is it here?──► solver (force devices: press_line.h)
//
// Nothing here waits. Each buffer has one writer and one reader.
//
// A topology is shared by the snapshots that name it. The solver lane writes a snapshot into a slot of a triple buffer,
// and that slot holds the topology until the solver lane writes into it again, long after the reader has given it back:
// so an old topology is freed on the solver's thread (or by whoever made a copy), never on the device thread, which
// copies none.
#include <atomic>
#include <memory>

#include "app/session/lattice_shown.h"
#include "app/session/notice.h"
#include "app/session/press_line.h"
#include "app/session/triple_buffer.h"
#include "devices/schedule.h"
#include "devices/spsc_ring.h"
#include "devices/state_sample.h"
#include "devices/tool_event.h"
#include "devices/virtual_hand.h"
#include "sim/patient/snapshot.h"

namespace limberg {

/// Where the hand is, and when its newest reading was taken.
struct HandState {
  ToolState tool;
  SecondHand glove, other_glove;
  int64_t sample_ns = -1;  // session time of the newest sample that went into it; -1 before any
};

/// The patient as shown, and the newest reading that it has seen.
struct PatientState {
  Snapshot snapshot;
  int64_t sample_ns = -1;
  LatticeShown lattice;  // empty unless wanted; of the state that the render thread gets
};

/// A stage of the operation, passed when Snapshot::stage reaches its number.
struct StageMark {
  int32_t number = 0;  // from 1
  ShortText name;
};

struct Channels {
  SpscRing<ToolEvent> events{1 << 14};  // 16 s of a gesture that makes an event on every tick
  SpscRing<Sample> samples{1 << 14};
  SpscRing<DeviceRun> device_runs{1 << 12};  // at most one a tick: 4 s
  SpscRing<SolverTake> solver_takes{1 << 10};
  SpscRing<StateSample> states{1 << 6};  // one a second
  SpscRing<StageMark> stages{1 << 10};
  SpscRing<Notice> notices{1 << 8};      // for a screen: where nobody empties it, later ones are dropped
  SpscRing<MissedPress> missed{1 << 6};  // the same
  std::atomic<bool> want_field{false};   // render asks the solver for the tension
  std::atomic<bool> want_lattice{false};
  std::atomic<bool> want_patient_shown{false};  // the main thread asks for patient_to_main
  std::atomic<bool> want_headset{false};        // a headset's drawing thread asks for what is to it
  TripleBuffer<HandState> hand_to_solver, hand_to_render, hand_to_headset;
  TripleBuffer<PatientState> patient_to_device, patient_to_render, patient_to_main, patient_to_headset;
  std::shared_ptr<PressLine> press;  // null: no device feels anything
};

}  // namespace limberg
