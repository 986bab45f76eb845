#include "render/picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "render/overlay.h"
#include "render/renderer.h"
#include "sim/geometry/triangle.h"

namespace limberg {

namespace {

constexpr float kFov = 24;  // degrees

// The end of the colour scale: a round number above the 99th percentile over the skin, at least one per cent.
double scale_end(const RenderScene& scene, double& highest) {
  std::vector<float> v;
  for (size_t i = 0; i < scene.field.size(); ++i)
    if (scene.mesh->part[i] == Part::skin && std::isfinite(scene.field[i])) v.push_back(100 * scene.field[i]);
  highest = 0;
  if (v.empty()) return 10;
  highest = *std::max_element(v.begin(), v.end());
  const auto at = v.begin() + std::ptrdiff_t(0.99 * double(v.size() - 1));
  std::nth_element(v.begin(), at, v.end());
  const double p99 = std::max(double(*at), 1.0), step = round_step(p99, 6);
  return step * std::ceil(p99 / step - 1e-9);
}

}  // namespace

// Between the eyes, as a share of the distance to what is looked at: 1 in 30, the rule of stereo photography.
constexpr double kEyes = 1. / 30;

double moved_scale_end(const RenderScene& scene) {
  std::vector<float> v;
  for (size_t i = 0; i < scene.field.size(); ++i)
    if (scene.mesh->part[i] == Part::face && std::isfinite(scene.field[i])) v.push_back(scene.field[i]);
  if (v.empty()) return 1;
  const auto at = v.begin() + std::ptrdiff_t(0.995 * double(v.size() - 1));
  std::nth_element(v.begin(), at, v.end());
  const double most = std::max(double(*at), 1.0), step = round_step(most, 6);
  return step * std::ceil(most / step - 1e-9);
}

namespace {

// Where the eye stands. Over a block: on the surgeon's side, 52 degrees above the
// skin, so that depth shows and shapes on the skin are hardly foreshortened. Over
// any other surface: in front of the skin that is looked at, a little below.
struct Stand {
  Vec3f from{0.10f, -0.60f, 0.79f}, up = Vec3f::UnitZ();
};
Stand stand_before(const Body* body, const Vec3f& low, const Vec3f& high) {
  if (!body) return {};
  const Vec3f e1 = body->chart_e1.cast<float>(), e2 = body->chart_e2.cast<float>(),
              n = body->chart_normal().cast<float>();
  if (body->is_box) return {0.10f * e1 - 0.60f * e2 + 0.79f * n, n};
  Vec3 sum = Vec3::Zero();
  const Vec3 middle = (0.5f * (low + high)).cast<double>(),
             reach = (0.5f * (high - low)).cast<double>() + Vec3::Constant(8);
  for (size_t t = 0; t < body->surface.tri.size(); ++t) {
    if (!body->surface.tag.empty() && body->surface.tag[t] != SurfaceTag::skin) continue;
    const auto& [a, b, c] = body->surface.tri[t];
    const Vec3 &A = body->surface.X_mm[size_t(a)], &B = body->surface.X_mm[size_t(b)],
               &C = body->surface.X_mm[size_t(c)];
    if (((A - middle).cwiseAbs() - reach).maxCoeff() < 0) sum += (B - A).cross(C - A);
  }
  const Vec3f front = sum.norm() > 0 ? Vec3f(sum.normalized().cast<float>()) : n;
  return {front - 0.25f * e2, e2};
}

}  // namespace

Camera camera_on_operated(const Snapshot& snapshot, double aspect) {
  const Body* body = snapshot.topology ? snapshot.topology->body.get() : nullptr;
  Vec3f low = Vec3f::Constant(-50), high = Vec3f::Constant(50);
  float margin = 1.08f;
  if (operated_box(snapshot, low, high)) {
    margin = 1;
    low -= Vec3f::Constant(3), high += Vec3f::Constant(3);  // room for bites and small wounds
  } else if (body) {
    skin_box(*body, low, high);
  }
  const Stand s = stand_before(body, low, high);
  return look_at_box(low, high, margin, s.from, s.up, kFov, aspect);
}

struct PictureMaker::Impl {
  int width, height;
  PictureQuality quality;
  Renderer renderer;
  SceneBuilder builder;
  TextPainter text;
  std::optional<Camera> camera;

  Impl(int w, int h, PictureQuality q, int threads)
      : width(w), height(h), quality(q), renderer(make_offscreen_context(threads)) {}

  double aspect() const { return double(width) / height; }

  void look(const Camera& from) {
    if (!camera) builder.seen_from(from);  // the lamp stays where it is when the eye goes round
    camera = from;
  }
  void look_at_snapshot(const Snapshot& snapshot) { look(camera_on_operated(snapshot, aspect())); }

  View view(const Snapshot& s) {
    if (!camera) look_at_snapshot(s);
    return camera->view(aspect());
  }

  DrawOptions options() const {
    const QualityLevel& level = quality == PictureQuality::still  ? kQualityLevels.back()
                                : quality == PictureQuality::film ? kQualityLevels[kFilmLevel]
                                                                  : kQualityLevels[kFastLevel];
    return draw_options(level, width, height);
  }
};

PictureMaker::PictureMaker(int width, int height, PictureQuality quality, int software_threads)
    : impl_(std::make_unique<Impl>(width, height, quality, software_threads)) {}
PictureMaker::~PictureMaker() = default;
PictureMaker::PictureMaker(PictureMaker&&) noexcept = default;

void PictureMaker::focus_from(const Snapshot& snapshot) { impl_->look_at_snapshot(snapshot); }
void PictureMaker::set_camera(const Camera& camera) { impl_->look(camera); }
const Camera& PictureMaker::camera() const {
  static const Camera unset{};
  return impl_->camera ? *impl_->camera : unset;
}

namespace {

/// Whether something that is drawn solid lies more than 3 mm before a place.
bool hidden(const Snapshot& s, const Vec3f& eye, const Vec3f& place, bool face_only) {
  const SurfaceTopology& top = *s.topology;
  const float far = (place - eye).norm() - 3;
  const Vec3f d = (place - eye).normalized();
  for (size_t t = 0; t < top.view.tri.size(); ++t) {
    if ((top.organ_of(t) == Organ::face) != face_only) continue;
    const Tri& k = top.view.tri[t];
    const auto met = meet_ray(eye, d, s.x_mm[size_t(k[0])], s.x_mm[size_t(k[1])], s.x_mm[size_t(k[2])]);
    if (met.met && met.at < far) return true;
  }
  return false;
}

/// Where names stand that lie close together: each beside its
/// dot, on the first of four sides where it covers no other name.
class NamePlaces {
 public:
  Eigen::Vector2d place(const Vec3f& dot, double width, double em) {
    const double x = double(dot.x()), y = double(dot.y());
    for (const Eigen::Vector2d& at :
         {Eigen::Vector2d(x + 0.45 * em, y - 0.25 * em), Eigen::Vector2d(x - 0.45 * em - width, y - 0.25 * em),
          Eigen::Vector2d(x + 0.45 * em, y + 0.95 * em), Eigen::Vector2d(x - 0.45 * em - width, y + 0.95 * em)})
      if (std::none_of(taken_.begin(), taken_.end(), [&](const Box& b) {
            return at.x() < b.right && b.left < at.x() + width && std::abs(at.y() - b.y) < 0.95 * em;
          }))
        return take(at, width);
    return take({x + 0.45 * em, y - 0.25 * em}, width);
  }

 private:
  struct Box {
    double left, right, y;
  };
  Eigen::Vector2d take(const Eigen::Vector2d& at, double width) {
    taken_.push_back({at.x(), at.x() + width, at.y()});
    return at;
  }
  std::vector<Box> taken_;
};

/// Whether a landmark is one of the face: it lies nearer to it than to bone.
bool on_face(const Snapshot& s, const Vec3f& place) {
  const SurfaceTopology& top = *s.topology;
  float face = std::numeric_limits<float>::max(), bone = face;
  for (size_t t = 0; t < top.view.tri.size(); ++t)
    if (const Organ o = top.organ_of(t); o != Organ::flesh)
      for (const int32_t v : top.view.tri[t]) {
        float& nearest = o == Organ::face ? face : bone;
        nearest = std::min(nearest, (s.x_mm[size_t(v)] - place).squaredNorm());
      }
  return face < bone;
}

/// Dots with names; those of the face where it hides the others.
void draw_landmarks(Image& image, const TextPainter& text, const Snapshot& s, const View& view, FaceLook face) {
  if (!s.topology) return;
  const double em = std::max(9.0, image.height / 48.0);
  NamePlaces names;
  for (size_t i = 0; i < std::min(s.landmark_mm.size(), s.topology->landmark.size()); ++i) {
    const std::string& name = s.topology->landmark[i];
    const bool of_face = on_face(s, s.landmark_mm[i]);
    if (of_face != (face == FaceLook::solid) || hidden(s, view.eye_mm, s.landmark_mm[i], of_face)) continue;
    const Vec3f p = view.to_pixel(s.landmark_mm[i], image.width, image.height);
    if (!p.allFinite() || p.x() < 0 || p.y() < 0 || p.x() >= float(image.width) || p.y() >= float(image.height))
      continue;
    const double r = 0.28 * em;
    for (int y = int(p.y() - r) - 1; y <= int(p.y() + r) + 1; ++y)
      for (int x = int(p.x() - r) - 1; x <= int(p.x() + r) + 1; ++x)
        if (x >= 0 && y >= 0 && x < image.width && y < image.height)
          image.blend(x, y, {30, 90, 220},
                      std::clamp(r - std::hypot(x + 0.5 - double(p.x()), y + 0.5 - double(p.y())) + 0.5, 0.0, 1.0));
    const TextPainter::Style white{em, {255, 255, 255}, true, 0.7};
    const Eigen::Vector2d at = names.place(p, text.width(name, white), em);
    text.draw(image, at.x(), at.y(), name, white);
  }
}

}  // namespace

Image PictureMaker::skin(const Snapshot& snapshot, const PictureOptions& options) {
  const RenderScene& scene = impl_->builder.build(snapshot, options.tool, options.strands);
  if (options.props) impl_->builder.add_props(*options.props);
  DrawOptions draw = impl_->options();
  draw.face = options.face, draw.wireframe = options.wireframe;
  const View view = impl_->view(snapshot);
  Image image;
  if (options.anaglyph) {
    const auto eyes = impl_->camera->stereo_pair(
        impl_->aspect(), kEyes * double((impl_->camera->eye_mm - impl_->camera->target_mm).norm()));
    impl_->renderer.paint_anaglyph(scene, eyes[0], eyes[1], draw);
    impl_->renderer.compose(impl_->width, impl_->height);
    image = impl_->renderer.read();
  } else {
    image = impl_->renderer.draw(scene, view, draw);
    if (options.landmarks) draw_landmarks(image, impl_->text, snapshot, view, options.face);
  }
  draw_caption(image, impl_->text, options.title, options.caption);
  return image;
}

Image PictureMaker::tension(const Snapshot& snapshot, const PictureOptions& options) {
  const RenderScene& scene = impl_->builder.build(snapshot, options.tool);
  double highest = 0;
  const double chosen = scale_end(scene, highest), end = options.field_max > 0 ? 100 * options.field_max : chosen;
  DrawOptions draw = impl_->options();
  draw.colour_field = true;
  draw.field_min = 0, draw.field_max = end / 100;
  draw.iso_lines = int(std::lround(end / round_step(end, 6)));
  Image image = impl_->renderer.draw(scene, impl_->view(snapshot), draw);
  draw_caption(image, impl_->text, options.title, options.caption);
  draw_legend(
      image, impl_->text,
      {options.legend.empty() ? "Skin stretch" : options.legend, options.unit.empty() ? "% of length" : options.unit, 0,
       end, ColourScale::magnitude, highest > end * 1.001, false, options.decimal});
  return image;
}

Image PictureMaker::field(const Snapshot& snapshot, std::span<const float> per_vertex, const Legend& legend,
                          const PictureOptions& options) {
  impl_->builder.build(snapshot, options.tool);
  const RenderScene& scene = impl_->builder.show_field(per_vertex);
  DrawOptions draw = impl_->options();
  draw.colour_field = true, draw.scale = legend.scale;
  draw.field_min = legend.min, draw.field_max = legend.max;
  draw.iso_lines = int(std::lround((legend.max - legend.min) / round_step(legend.max - legend.min, 6)));
  Image image = impl_->renderer.draw(scene, impl_->view(snapshot), draw);
  draw_caption(image, impl_->text, options.title, options.caption);
  draw_legend(image, impl_->text, legend);
  return image;
}

Image PictureMaker::moved(const Snapshot& snapshot, const PictureOptions& options) {
  const RenderScene& scene = impl_->builder.build(snapshot, options.tool, options.strands);
  const double end = options.field_max > 0 ? options.field_max : moved_scale_end(scene);
  const double highest = scene.field.empty() ? 0 : double(*std::max_element(scene.field.begin(), scene.field.end()));
  DrawOptions draw = impl_->options();
  draw.face = options.face;
  draw.colour_field = true;
  draw.field_min = 0, draw.field_max = end;
  draw.iso_lines = int(std::lround(end / round_step(end, 6)));
  const View view = impl_->view(snapshot);
  Image image = impl_->renderer.draw(scene, view, draw);
  if (options.landmarks) draw_landmarks(image, impl_->text, snapshot, view, options.face);
  draw_caption(image, impl_->text, options.title, options.caption);
  draw_legend(image, impl_->text,
              {options.legend.empty() ? "The face has moved" : options.legend, "mm", 0, end, ColourScale::magnitude,
               highest > end * 1.001, false, options.decimal});
  return image;
}

std::string PictureMaker::describe() const { return impl_->renderer.describe(); }

}  // namespace limberg
