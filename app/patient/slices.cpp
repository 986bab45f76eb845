#include "app/patient/slices.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/result/output.h"
#include "render/text.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

constexpr const char* kSlicesFolder = "slices";
constexpr double kSliceMargin_mm = 12, kSliceBar_mm = 10;
constexpr int kMostSubsamples = 4;  // along a pixel's side

struct SliceWords {
  const char *name, *axis, *seen;
  const char *left, *right, *top, *bottom;
};
const SliceWords& words_of(SlicePlane p) {
  static constexpr SliceWords kWords[] = {
      {"Axial", "z", "Seen from the feet: the patient's right is on the left, anterior is up.", "R", "L", "A", "P"},
      {"Coronal", "y", "Seen from the front: the patient's right is on the left, superior is up.", "R", "L", "S", "I"},
      {"Sagittal", "x", "Seen from the patient's left: anterior is on the left, superior is up.", "A", "P", "S", "I"}};
  return kWords[size_t(p)];
}

std::string slice_title(const Slice& s) {
  const double shown = std::abs(s.at_mm) < 0.05 ? 0 : s.at_mm;
  return fmt::format("{}, {} = {:.1f} mm", words_of(s.plane).name, words_of(s.plane).axis, shown);
}

/// How much of each pixel a line one pixel wide covers; where segments meet the larger share, so that joints are no
/// beads.
void cover(std::vector<float>& share, const SliceFrame& f, const Vec2& a, const Vec2& b) {
  const Vec2 ab = b - a, low = a.cwiseMin(b), high = a.cwiseMax(b);
  const double length2 = ab.squaredNorm();
  const int i0 = int(std::clamp(std::floor(low.x() - 1.5), 0., double(f.width))),
            i1 = int(std::clamp(std::ceil(high.x() + 1.5), 0., double(f.width))),
            j0 = int(std::clamp(std::floor(low.y() - 1.5), 0., double(f.height))),
            j1 = int(std::clamp(std::ceil(high.y() + 1.5), 0., double(f.height)));
  for (int j = j0; j < j1; ++j)
    for (int i = i0; i < i1; ++i) {
      const Vec2 ap = Vec2(i + 0.5, j + 0.5) - a;
      const double t = length2 > 0 ? std::clamp(ap.dot(ab) / length2, 0., 1.) : 0;
      float& s = share[size_t(j) * size_t(f.width) + size_t(i)];
      s = std::max(s, float(1 - (ap - t * ab).norm()));
    }
}

void draw_grey(Image& image, const Volume& v, const SliceFrame& f, const SliceLook& look) {
  const VolumeSampler sampler(v);
  double voxel = v.step_mm.col(0).norm();
  for (int k = 1; k < 3; ++k) voxel = std::min(voxel, v.step_mm.col(k).norm());
  const int n = int(std::clamp(std::ceil(f.pixel_mm / voxel - 1e-6), 1., double(kMostSubsamples)));
  const double black = look.centre_HU + look.offset - 0.5 * look.width_HU;
  for (int j = 0; j < f.height; ++j)
    for (int i = 0; i < f.width; ++i) {
      double sum = 0;
      for (int k = 0; k < n * n; ++k) {
        const Vec3 x = f.place(i + (k % n + 0.5) / n, j + (k / n + 0.5) / n);
        if (sampler.inside(x)) sum += std::clamp((sampler.value(x) - black) / look.width_HU, 0., 1.);
      }
      const auto grey = uint8_t(std::lround(255 * sum / (n * n)));
      image.set(i, j, {grey, grey, grey});
    }
}

void draw_words(Image& image, std::span<const SliceContour> contours, const Slice& slice, const SliceFrame& f) {
  const double w = f.width, h = f.height, em = std::clamp(std::min(w, h) / 26, 11., 22.), edge = 0.4 * em;
  const Rgb8 white{255, 255, 255}, black{0, 0, 0};
  const int length = int(std::lround(kSliceBar_mm / f.pixel_mm)), thick = std::max(2, int(em / 5));
  const int x1 = f.width - int(edge) - 1, y1 = f.height - int(edge) - 1;
  for (int y = y1 - thick - 1; y <= y1; ++y)
    for (int x = x1 - length - 1; x <= x1; ++x) {
      const bool frame = y == y1 - thick - 1 || y == y1 || x == x1 - length - 1 || x == x1;
      image.blend(x, y, frame ? black : white, frame ? 0.6 : 1);
    }
  const TextPainter text;
  const auto write = [&](double x, double y, const std::string& s, double px, Rgb8 colour, bool bold) {
    text.draw(image, x, y, s, {px, colour, bold, 0.8});
  };
  const auto wide = [&](const std::string& s, double px, bool bold) { return text.width(s, {px, white, bold, 0}); };
  const std::string bar = fmt::format("{:.0f} mm", kSliceBar_mm), title = slice_title(slice);
  const double bar_wide = wide(bar, 0.9 * em, false);
  write(std::min(x1 - 0.5 * length - 0.5 * bar_wide, w - edge - bar_wide), y1 - thick - 0.4 * em, bar, 0.9 * em, white,
        false);
  const SliceWords& at = words_of(slice.plane);
  const double big = 1.15 * em;
  write(edge, 0.5 * h + 0.4 * big, at.left, big, white, true);
  write(w - edge - wide(at.right, big, true), 0.5 * h + 0.4 * big, at.right, big, white, true);
  const double top_left = 0.5 * w - 0.5 * wide(at.top, big, true);
  write(top_left, edge + big, at.top, big, white, true);
  const bool fits = edge + wide(title, em, false) + edge < top_left;  // else it goes below that letter
  write(edge, edge + em + (fits ? 0 : big), title, em, white, false);
  write(0.5 * w - 0.5 * wide(at.bottom, big, true), h - edge, at.bottom, big, white, true);
  for (size_t c = 0; c < contours.size(); ++c)
    write(edge, h - edge - 1.25 * em * double(contours.size() - 1 - c), contours[c].name, em, contours[c].colour, true);
}

}  // namespace

Vec3 SliceFrame::place(double column, double row) const {
  Vec3 x;
  x[through] = at_mm, x[across] = left_mm + column * pixel_mm, x[down] = top_mm + down_sign * row * pixel_mm;
  return x;
}

Vec2 SliceFrame::pixel(const Vec3& x) const {
  return Vec2(x[across] - left_mm, down_sign * (x[down] - top_mm)) / pixel_mm;
}

SliceFrame slice_frame(const Slice& slice, const Vec3& low, const Vec3& high, const SliceLook& look) {
  if (!low.allFinite() || !high.allFinite() || !(high - low).allFinite() || !std::isfinite(slice.at_mm))
    throw InputError("", 0, "a slice and a box in finite numbers were expected");
  if (!(look.pixel_mm > 0 && look.most_pixels > 0 && look.width_HU > 0) ||
      !std::isfinite(look.pixel_mm + look.width_HU + look.centre_HU + look.offset))
    throw InputError("", 0, "pixels and a window above 0 were expected for the slices");
  SliceFrame f;
  f.through = slice.plane == SlicePlane::axial ? 2 : slice.plane == SlicePlane::coronal ? 1 : 0;
  f.across = slice.plane == SlicePlane::sagittal ? 1 : 0;
  f.down = slice.plane == SlicePlane::axial ? 1 : 2;
  f.down_sign = slice.plane == SlicePlane::axial ? 1 : -1;
  const double wide = high[f.across] - low[f.across], tall = high[f.down] - low[f.down];
  f.pixel_mm = std::max(look.pixel_mm, std::max(wide, tall) / look.most_pixels);
  const auto pixels = [&](double mm) {
    return std::clamp(int(std::ceil(mm / f.pixel_mm - 1e-6)), 1, look.most_pixels);
  };
  f.width = pixels(wide), f.height = pixels(tall);
  f.at_mm = slice.at_mm, f.left_mm = low[f.across], f.top_mm = f.down_sign > 0 ? low[f.down] : high[f.down];
  return f;
}

std::vector<std::array<Vec3, 2>> cut_by_plane(std::span<const Vec3> x, std::span<const Tri> tri, int axis,
                                              double at_mm) {
  const auto above = [&](int32_t v) { return x[size_t(v)][axis] >= at_mm; };
  // From the lower number to the higher, whichever triangle asks.
  const auto crossing = [&](int32_t u, int32_t v) {
    const Vec3 &a = x[size_t(std::min(u, v))], &b = x[size_t(std::max(u, v))];
    if (a[axis] == at_mm) return a;
    if (b[axis] == at_mm) return b;
    Vec3 p = a + (at_mm - a[axis]) / (b[axis] - a[axis]) * (b - a);
    p[axis] = at_mm;
    return p;
  };
  std::vector<std::array<Vec3, 2>> segments;
  for (const Tri& t : tri) {
    const std::array<bool, 3> up{above(t[0]), above(t[1]), above(t[2])};
    if (up[0] == up[1] && up[1] == up[2]) continue;
    const size_t lone = up[1] == up[2] ? 0 : up[0] == up[2] ? 1 : 2;  // this corner is on its side alone
    const std::array<Vec3, 2> s{crossing(t[lone], t[(lone + 1) % 3]), crossing(t[lone], t[(lone + 2) % 3])};
    if (s[0] != s[1]) segments.push_back(s);
  }
  return segments;
}

Image draw_slice(const Volume& volume, std::span<const SliceContour> contours, const Slice& slice, const SliceFrame& f,
                 const SliceLook& look) {
  Image image(f.width, f.height);
  draw_grey(image, volume, f, look);
  std::vector<float> share;
  for (const SliceContour& c : contours) {
    share.assign(size_t(f.width) * size_t(f.height), 0);
    for (const auto& [a, b] : cut_by_plane(c.x_mm, c.tri, f.through, f.at_mm)) cover(share, f, f.pixel(a), f.pixel(b));
    for (int j = 0; j < f.height; ++j)
      for (int i = 0; i < f.width; ++i)
        image.blend(i, j, c.colour, double(share[size_t(j) * size_t(f.width) + size_t(i)]));
  }
  if (look.words) draw_words(image, contours, slice, f);
  return image;
}

std::string slice_caption(const Slice& slice) { return slice_title(slice) + ". " + words_of(slice.plane).seen; }

std::vector<Slice> slices_of_box(const Vec3& low, const Vec3& high, const SliceCounts& counts) {
  std::vector<Slice> all;
  const auto add = [&](SlicePlane plane, int n, double from, double to) {
    for (int i = 0; i < n; ++i) all.push_back({plane, from + (to - from) * (i + 0.5) / n});
  };
  add(SlicePlane::axial, counts.axial, high.z(), low.z());
  add(SlicePlane::coronal, counts.coronal, low.y(), high.y());
  add(SlicePlane::sagittal, counts.sagittal, low.x(), high.x());
  return all;
}

std::vector<ResultPicture> draw_head_slices(const std::string& dir, const Volume& volume,
                                            std::span<const SliceContour> contours, const SliceLook& look,
                                            const SliceCounts& counts) {
  Vec3 low = Vec3::Constant(1e300), high = -low;
  const auto grow = [&](const Vec3& x) { low = low.cwiseMin(x), high = high.cwiseMax(x); };
  for (const SliceContour& c : contours)
    for (const Tri& t : c.tri)  // vertices that no triangle uses show nowhere
      for (const int32_t v : t) grow(c.x_mm[size_t(v)]);
  if (low.x() > high.x())
    for (int c = 0; c < 8; ++c)
      grow(volume.place(
          Vec3((c & 1) * (volume.size[0] - 1), (c >> 1 & 1) * (volume.size[1] - 1), (c >> 2) * (volume.size[2] - 1))));
  const Vec3 margin = Vec3::Constant(kSliceMargin_mm);
  prepare_folder(dir + "/" + kSlicesFolder);
  std::vector<ResultPicture> pictures;
  std::array<int, 3> number{};
  for (const Slice& s : slices_of_box(low, high, counts)) {
    constexpr const char* kNames[] = {"axial", "coronal", "sagittal"};
    const std::string file =
        fmt::format("{}/{}-{}.png", kSlicesFolder, kNames[size_t(s.plane)], ++number[size_t(s.plane)]);
    const SliceFrame frame = slice_frame(s, low - margin, high + margin, look);
    write_png(dir + "/" + file, draw_slice(volume, contours, s, frame, look));
    pictures.push_back({file, slice_caption(s)});
  }
  return pictures;
}

}  // namespace limberg
