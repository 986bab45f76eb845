#include "sim/skull/simplex/file.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "sim/base/error.h"
#include "sim/base/quoted.h"
#include "sim/base/whole_file.h"
#include "sim/skull/simplex/contour.h"
#include "sim/skull/simplex/dual.h"

namespace limberg::simplex {
namespace {

constexpr const char* kBranch[] = {"near", "far", "height"};
constexpr const char* kAxes[] = {"", "lps", "head"};  // in the order of Axes

template <class T>
void put(std::string& s, T v) {
  char b[40];
  const auto r = std::to_chars(b, b + sizeof b, v);
  s += ' ';
  s.append(b, r.ptr);
}
void put(std::string& s, const Vec3& x) {
  for (int k = 0; k < 3; ++k) put(s, x[k]);
}

class Parser {
 public:
  Parser(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  Mesh run() {
    if (text_.size() > FileLimits::file_bytes) throw InputError(name_, 0, "the file is larger than 1 GB");
    for (size_t at = 0; at < text_.size();) {
      const size_t end = std::min(text_.find('\n', at), text_.size());
      rest_ = text_.substr(at, end - at);
      at = end + 1;
      ++line_;
      if (const size_t hash = rest_.find('#'); hash != std::string_view::npos) rest_ = rest_.substr(0, hash);
      const std::string_view key = word();
      if (key.empty()) continue;
      if (!begun_)
        begin(key);
      else
        statement(key);
      if (!word().empty()) fail("there is more on the line than the statement has");
    }
    if (!begun_)
      throw InputError(name_, 0, "the file is empty; expected a simplex mesh that begins with limberg-simplex 1");
    if (nbr_.empty()) throw InputError(name_, 0, "there are no vertices");
    return finish();
  }

 private:
  struct End {
    int32_t a, b;
    FaceKind kind;
    int line;
  };
  struct Ring {
    std::vector<int32_t> v;
    int line;
  };
  [[noreturn]] void fail(const std::string& what) const { throw InputError(name_, line_, what); }

  std::string_view word() {
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    size_t a = 0;
    while (a < rest_.size() && blank(rest_[a])) ++a;
    size_t b = a;
    while (b < rest_.size() && !blank(rest_[b])) ++b;
    const std::string_view w = rest_.substr(a, b - a);
    rest_.remove_prefix(b);
    return w;
  }
  double real() {
    const std::string_view w = word();
    double v = 0;
    const auto [end, ec] = std::from_chars(w.data(), w.data() + w.size(), v);
    if (w.empty() || ec != std::errc() || end != w.data() + w.size() || !std::isfinite(v))
      fail("a finite number was expected instead of " + quoted(w));
    return v;
  }
  int32_t whole(int32_t most) {
    const std::string_view w = word();
    int32_t v = -1;
    const auto [end, ec] = std::from_chars(w.data(), w.data() + w.size(), v);
    if (w.empty() || ec != std::errc() || end != w.data() + w.size() || v < 0 || v > most)
      fail("a whole number from 0 to " + std::to_string(most) + " was expected instead of " + quoted(w));
    return v;
  }
  Vec3 place() {
    Vec3 x;
    for (int k = 0; k < 3; ++k) x[k] = real();
    if (x.cwiseAbs().maxCoeff() > FileLimits::extent_mm) fail("a place is more than a kilometre from the origin");
    return x;
  }

  void begin(std::string_view key) {
    if (key != "limberg-simplex") fail("this is no simplex mesh; the first line was expected to be limberg-simplex 1");
    if (word() != "1") fail("this version of the format is not known; expected 1");
    begun_ = true;
  }

  void statement(std::string_view key) {
    if (key == "v") {
      if (int32_t(nbr_.size()) == FileLimits::vertices)
        fail("there are more than " + std::to_string(FileLimits::vertices) + " vertices");
      x_.push_back(place()), before_.push_back(x_.back());
      Row r;
      for (int32_t& n : r) n = whole(FileLimits::vertices - 1);
      nbr_.push_back(r);
      zone_.push_back(0), flags_.push_back(0), metric_.push_back({1. / 3, 1. / 3}), shape_.emplace_back(),
          shaped_.push_back(0);
      return;
    }
    if (key == "axes") {
      const std::string_view which = word();
      if (axes_ != Axes::unsaid) fail("says a second time which way the axes point");
      if (!nbr_.empty()) fail("axes was expected before the first vertex");
      if (which != kAxes[1] && which != kAxes[2]) fail(quoted(which) + " are no known axes; expected lps or head");
      axes_ = which == kAxes[1] ? Axes::left_posterior_superior : Axes::right_forwards_up;
      return;
    }
    if (key == "e") {
      const int32_t a = whole(FileLimits::vertices - 1), b = whole(FileLimits::vertices - 1);
      const std::string_view kind = word();
      if (kind != "hole" && kind != "cut" && kind != "wall") fail("a marked face is a hole, a cut or a wall");
      ends_.push_back({a, b, kind == "hole" ? FaceKind::hole : kind == "cut" ? FaceKind::cut : FaceKind::wall, line_});
      return;
    }
    if (key == "c") {
      Ring ring{{}, line_};
      for (;;) {
        const std::string_view kept = rest_;
        if (word().empty()) break;
        rest_ = kept;
        ring.v.push_back(whole(FileLimits::vertices - 1));
      }
      rings_.push_back(std::move(ring));
      return;
    }
    if (key != "b" && key != "z" && key != "l" && key != "m" && key != "s")
      fail(quoted(key) + " is no statement; expected axes, v, b, z, l, m, s, e or c");
    if (nbr_.empty()) fail(quoted(key) + " belongs to a vertex; a v was expected before it");
    if (key == "b") {
      before_.back() = place();
    } else if (key == "z") {
      zone_.back() = uint16_t(whole(65535));
    } else if (key == "l") {
      flags_.back() |= kLocked;
    } else if (key == "m") {
      metric_.back()[0] = real(), metric_.back()[1] = real();
    } else {
      VertexShape& s = shape_.back();
      s.e1 = real(), s.e2 = real(), s.phi = real(), s.height = real();
      const std::string_view b = word();
      const auto at = std::find_if(std::begin(kBranch), std::end(kBranch), [&](const char* n) { return b == n; });
      if (at == std::end(kBranch)) fail("a shape ends with near, far or height");
      s.branch = ShapeBranch(at - std::begin(kBranch));
      shaped_.back() = 1;
    }
  }

  Mesh finish() {
    Mesh m;
    try {
      m = make_mesh(std::move(nbr_), std::move(x_));
    } catch (const InputError& e) {
      throw InputError(name_, 0, e.what());
    }
    m.axes = axes_;
    m.before_mm = std::move(before_), m.zone = std::move(zone_), m.flags = std::move(flags_),
    m.metric = std::move(metric_);
    for (size_t v = 0; v < shaped_.size(); ++v)
      if (shaped_[v]) m.shape[v] = shape_[v];
    for (const End& e : ends_) {
      if (!m.alive(e.a) || !m.alive(e.b) || m.slot(e.a, e.b) < 0)
        throw InputError(name_, e.line,
                         "vertices " + std::to_string(e.a) + " and " + std::to_string(e.b) + " are not neighbours");
      m.face_kind[size_t(m.face(m.edge(e.a, e.b)))] = e.kind;
    }
    for (const Ring& r : rings_)
      if (const std::string bad = keep_contour(m, r.v); !bad.empty()) throw InputError(name_, r.line, bad);
    return m;
  }

  std::string_view text_, rest_;
  const std::string& name_;
  int line_ = 0;
  bool begun_ = false;
  Axes axes_ = Axes::unsaid;
  std::vector<Row> nbr_;
  std::vector<Vec3> x_, before_;
  std::vector<uint16_t> zone_;
  std::vector<uint8_t> flags_, shaped_;
  std::vector<std::array<double, 2>> metric_;
  std::vector<VertexShape> shape_;
  std::vector<End> ends_;
  std::vector<Ring> rings_;
};

}  // namespace

std::string to_text(const Mesh& given) {
  Mesh packed;
  if (!given.free_vertex.empty() || !given.free_face.empty()) packed = given, compact(packed);
  const Mesh& m = packed.nbr.empty() ? given : packed;
  std::string s = "limberg-simplex 1\n";
  if (m.axes != Axes::unsaid) s += std::string("axes ") + kAxes[size_t(m.axes)] + '\n';
  const VertexShape none;
  for (int32_t v = 0; v < m.slots(); ++v) {
    const size_t i = size_t(v);
    s += 'v', put(s, m.x_mm[i]);
    for (int32_t n : m.nbr[i]) put(s, n);
    s += '\n';
    if (m.before_mm[i] != m.x_mm[i]) s += 'b', put(s, m.before_mm[i]), s += '\n';
    if (m.zone[i] != 0) s += 'z', put(s, m.zone[i]), s += '\n';
    if (m.flags[i] & kLocked) s += "l\n";
    if (m.metric[i] != std::array<double, 2>{1. / 3, 1. / 3})
      s += 'm', put(s, m.metric[i][0]), put(s, m.metric[i][1]), s += '\n';
    const Row& r = m.nbr[i];
    if (const VertexShape& q = m.shape[i];
        !(q == encode(m.x_mm[i], m.x_mm[size_t(r[0])], m.x_mm[size_t(r[1])], m.x_mm[size_t(r[2])])))
      s += 's', put(s, q.e1), put(s, q.e2), put(s, q.phi), put(s, q.height), s += ' ', s += kBranch[int(q.branch)],
          s += '\n';
  }
  for (const EndContour& e : end_contours(m))
    s += 'e', put(s, e.rim[0]), put(s, e.rim[1]), s += e.kind == FaceKind::hole ? " hole\n" : " cut\n";
  for (int32_t f = 0; f < m.face_slots(); ++f)
    if (m.alive_face(f) && m.kind(f) == FaceKind::wall)
      s += 'e', put(s, m.from(m.face_edge[size_t(f)])), put(s, m.to(m.face_edge[size_t(f)])), s += " wall\n";
  for (const auto& c : m.contour) {
    s += 'c';
    for (int32_t v : c) put(s, v);
    s += '\n';
  }
  return s;
}

Mesh parse_mesh(std::string_view text, const std::string& name) { return Parser(text, name).run(); }

void save_mesh(const Mesh& m, const std::string& path) { write_whole_file(path, to_text(m)); }

Mesh load_mesh(const std::string& path) {
  return parse_mesh(read_whole_file(path, FileLimits::file_bytes, "a simplex mesh"), path);
}

std::string to_obj(const Mesh& m) {
  const FanTriangles f = fan_triangles(m);
  std::string s;
  for (const Vec3& x : f.X_mm) s += 'v', put(s, x), s += '\n';
  for (const Tri& t : f.tri) {
    s += 'f';
    for (int32_t v : t) put(s, v + 1);
    s += '\n';
  }
  return s;
}

}  // namespace limberg::simplex
