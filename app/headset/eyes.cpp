#include "app/headset/eyes.h"

#include <algorithm>

#include "app/pictures/pictures.h"
#include "devices/monotonic.h"

namespace limberg {

namespace {

constexpr int kEyeLevels = 4;            // without occlusion: it is of the screen, and differs between the eyes
constexpr double kShareOfPeriod = 0.65;  // the rest is the runtime's
constexpr double kNear_m = 0.05, kFar_m = 9;
constexpr Rgb8 kWalls{58, 66, 70};

}  // namespace

std::array<View, 2> views_of(const HeadsetFrame& f, const PatientPlace& place) {
  std::array<View, 2> views;
  const float mm = float(place.mm_per_m());
  for (size_t e = 0; e < 2; ++e)
    views[e] = eye_view(place.to_patient(f.eye[e].pose.at_m).cast<float>(),
                        place.to_patient(f.eye[e].pose.turned).cast<float>(), f.eye[e].angles, float(kNear_m) * mm,
                        float(kFar_m) * mm);
  return views;
}

double floor_below_m(const PatientPlace& place, bool floor) { return floor ? place.at_m().y() : 0.9; }

DrawOptions eye_options(const QualityLevel& level, int width, int height) {
  DrawOptions o = draw_options(level, width, height);
  o.occlusion = false, o.supersample = 1;
  o.background_top = o.background_bottom = kWalls;
  return o;
}

Eyes::Eyes(std::unique_ptr<GlContext> context, HeadsetShared& shared, SharedPlace& place, const EyesSettings& settings,
           bool floor)
    : shared_(shared),
      place_(place),
      set_(settings),
      floor_(floor),
      renderer_(std::move(context)),
      board_(renderer_.functions()),
      copy_(renderer_.functions()),
      ladder_(1, kEyeLevels, kFastLevel) {
  if (shared_.channels) shared_.channels->want_headset.store(true, std::memory_order_relaxed);
}

Eyes::~Eyes() {
  if (shared_.channels && !shared_.over) shared_.channels->want_headset.store(false, std::memory_order_relaxed);
}

// The picture stays where it is in the room until the person asks for it (HandReading::place): the head alone moves
// what is seen.
void Eyes::put(const RoomPose& head) {
  placed_ = place_.get(patient_, tablet_);
  if (placed_) return;
  constexpr double kTabletAspect = 16. / 9;
  patient_ = PatientPlace::before(head, floor_, shared_.camera, set_.room);
  builder_.seen_from(shared_.camera);
  const double aspect =
      on_tablet_ && on_tablet_->height > 0 ? double(on_tablet_->width) / on_tablet_->height : kTabletAspect;
  tablet_ = tablet_place(patient_, head, aspect);
  room_.clear();
  place_.set(patient_, tablet_);
}

bool Eyes::begin(const HeadsetFrame& frame) {
  time_frame(frame);
  frame_ = frame;
  if (const auto image = shared_.tablet.newer(tablet_version_)) {
    on_tablet_ = image;
    if (!image->empty()) board_.show(*image);
  }
  put(frame.head);
  view_ = views_of(frame, patient_);
  scene_ = shared_.channels && !shared_.over ? &build() : nullptr;
  ++frames_;
  return scene_ && scene_->mesh && !scene_->mesh->tri.empty();
}

const RenderScene& Eyes::build() {
  Channels& ch = *shared_.channels;
  ch.patient_to_headset.update();
  ch.hand_to_headset.update();
  const Snapshot& s = ch.patient_to_headset.reading().snapshot;
  const HandState& hand = ch.hand_to_headset.reading();
  const RenderScene& scene = builder_.build(s, tool_pose(hand.tool, hand.glove, hand.other_glove));
  if (!s.topology) return scene;
  if (room_.tri.empty())
    room_ = room_props(patient_, scene.bounds_min, scene.bounds_max, floor_below_m(patient_, floor_));
  builder_.add_props(room_);
  return scene;
}

/// Fine or fast by how long the frame before took; one that came too late took as long as it was waited for.
void Eyes::time_frame(const HeadsetFrame& f) {
  if (frames_ > 0 && f.period_ns > 0) {
    const double apart_ns = double(f.seen_ns - seen_ns_);
    const bool late = apart_ns > 1.5 * double(f.period_ns);
    ladder_.frame((late ? apart_ns : double(took_ns_)) / (kShareOfPeriod * double(f.period_ns)));
  }
  began_ns_ = monotonic_ns(), seen_ns_ = f.seen_ns;
}

void Eyes::eye(int which, unsigned texture, int width, int height) {
  const int level = set_.level >= 0 ? set_.level : ladder_.level();
  DrawOptions o =
      eye_options(kQualityLevels[size_t(std::clamp(level, 0, int(kQualityLevels.size()) - 1))], width, height);
  const View& view = view_[size_t(which)];
  renderer_.paint(*scene_, std::span(&view, 1), o);
  const int w = (width + o.shrink - 1) / o.shrink, h = (height + o.shrink - 1) / o.shrink;
  if (on_tablet_) board_.paint(view, tablet_, w, h, place_.dot_u, place_.dot_v);
  copy_.copy(w, h, texture, width, height);
  took_ns_ = monotonic_ns() - began_ns_;
  if (which == 1) all_ns_ += took_ns_;
}

}  // namespace limberg
