#pragma once
// The entries of result.json's lists, each once: a plain struct and its fields by name. Results are written from these
// structs (write_fields) and the report reads them back (report_data.cpp): a field is added in one place. What a run
// says beside its lists stands in run_result.h; what one command alone says, beside that command.
//
// A Maybe of any kind that is empty is not written. A text that is no Maybe is written unless it is empty.
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "app/result/result.h"

namespace limberg {

using Maybe = std::optional<double>;
using MaybeCount = std::optional<int64_t>;     // a whole number of things
using MaybeText = std::optional<std::string>;  // written though it is empty
using MaybeFlag = std::optional<bool>;
template <class T>
using MaybeList = std::optional<std::vector<T>>;  // written though it is empty
using ResultVector = std::array<double, 3>;       // to the last bit; a vector<double> has six digits

/// A text that may be absent.
inline std::string said(const MaybeText& text) { return text.value_or(""); }
/// Those of a list that may be absent.
template <class T>
const std::vector<T>& entries(const MaybeList<T>& list) {
  static const std::vector<T> none;
  return list ? *list : none;
}
/// No list at all instead of an empty one.
template <class T>
MaybeList<T> unless_empty(std::vector<T> list) {
  return list.empty() ? MaybeList<T>() : MaybeList<T>(std::move(list));
}

/// A time's percentiles: ms or us, as the name of the list says.
struct ResultTimes {
  Maybe p50, p95, p99, p999, max;
  bool any() const { return p50 || p95 || p99 || p999 || max; }
};
template <class F>
void fields(ResultTimes& x, F&& f) {
  f("p50", x.p50), f("p95", x.p95), f("p99", x.p99), f("p999", x.p999), f("max", x.max);
}

/// metrics/sutures
struct ResultSuture {
  MaybeCount id;
  Maybe force_N, gap_mm, tied_N, peak_N;
  std::vector<double> at_mm;  // the middle of the stitch, in the world
  MaybeCount thread;          // stitches of one thread have one number
};
template <class F>
void fields(ResultSuture& x, F&& f) {
  f("id", x.id), f("force_N", x.force_N), f("gap_mm", x.gap_mm), f("at_mm", x.at_mm), f("tied_N", x.tied_N);
  f("peak_N", x.peak_N), f("thread", x.thread);
}

/// metrics/predicted: where the plan said that the skin stands up or is drawn tight.
struct ResultPoint {
  Maybe charge_deg, x_mm, y_mm, reach_mm, height_mm, volume_mm3, deficit_deg;
};
template <class F>
void fields(ResultPoint& x, F&& f) {
  f("charge_deg", x.charge_deg), f("x_mm", x.x_mm), f("y_mm", x.y_mm), f("reach_mm", x.reach_mm);
  f("height_mm", x.height_mm), f("volume_mm3", x.volume_mm3), f("deficit_deg", x.deficit_deg);
}

/// metrics/landmarks. displacement_mm is null where the landmark's skin is gone.
struct ResultLandmark {
  std::string name;
  Maybe x_mm, y_mm, displacement_mm, along_mm, across_mm, up_mm;
};
template <class F>
void fields(ResultLandmark& x, F&& f) {
  f("name", x.name), f("x_mm", x.x_mm), f("y_mm", x.y_mm), f("displacement_mm", x.displacement_mm);
  f("along_mm", x.along_mm), f("across_mm", x.across_mm), f("up_mm", x.up_mm);
}

struct ResultTable {
  std::string title, about;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;  // as the columns
};
template <class F>
void fields(ResultTable& x, F&& f) {
  f("title", x.title), f("about", x.about), f("columns", x.columns), f("rows", x.rows);
}

/// verdict: what was looked at, what is bad first. value, limit: no number where there is none. light: verdict_words.h.
struct ResultVerdict {
  std::string what;
  double value = std::numeric_limits<double>::quiet_NaN();
  std::string unit;
  double limit = std::numeric_limits<double>::quiet_NaN();
  std::string place, light, source;  // source: where the limit comes from
};
template <class F>
void fields(ResultVerdict& x, F&& f) {
  f("what", x.what), f("value", x.value), f("unit", x.unit), f("limit", x.limit), f("place", x.place);
  f("light", x.light), f("source", x.source);
}

/// lesson/tolerances
struct ResultTolerance {
  std::string name, unit;
  Maybe limit, value;
  bool met = false;
  std::string why;  // there is no value
};
template <class F>
void fields(ResultTolerance& x, F&& f) {
  f("name", x.name), f("unit", x.unit), f("limit", x.limit), f("value", x.value), f("why", x.why), f("met", x.met);
}

/// stages; picture: relative to the result's folder.
struct ResultStage {
  std::string name, picture, caption;
  Maybe t_s, residual;
  MaybeCount sutures, pieces;
};
template <class F>
void fields(ResultStage& x, F&& f) {
  f("name", x.name), f("picture", x.picture), f("caption", x.caption), f("t_s", x.t_s), f("residual", x.residual);
  f("sutures", x.sutures), f("pieces", x.pieces);
}

/// gallery
struct ResultPicture {
  std::string picture, caption;
};
template <class F>
void fields(ResultPicture& x, F&& f) {
  f("picture", x.picture), f("caption", x.caption);
}

/// refused: acts that the patient refused; t_s of a session, line of a script.
struct ResultRefusal {
  Maybe t_s, line;
  std::string action, reason;
};
template <class F>
void fields(ResultRefusal& x, F&& f) {
  f("t_s", x.t_s), f("line", x.line), f("action", x.action), f("reason", x.reason);
}

/// convergence/N/difference: from the coarser lattice before it.
struct ResultChange {
  Maybe closure_force_N, suture_gap_max_mm, dog_ear_mm;
};
template <class F>
void fields(ResultChange& x, F&& f) {
  f("closure_force_N", x.closure_force_N), f("suture_gap_max_mm", x.suture_gap_max_mm), f("dog_ear_mm", x.dog_ear_mm);
}

/// convergence: the same operation on one lattice of several. fitted_cell_mm: cube root of a cell of the lattice, which
/// is fitted to a block.
struct ResultConvergence {
  Maybe cell_mm, closure_force_N, suture_gap_max_mm, suture_force_max_N, dog_ear_mm, residual, solve_ms;
  MaybeCount nodes;
  Maybe fitted_cell_mm, distance_mm;
  ResultChange difference;
};
template <class F>
void fields(ResultConvergence& x, F&& f) {
  f("cell_mm", x.cell_mm), f("nodes", x.nodes), f("closure_force_N", x.closure_force_N);
  f("suture_gap_max_mm", x.suture_gap_max_mm), f("suture_force_max_N", x.suture_force_max_N);
  f("dog_ear_mm", x.dog_ear_mm), f("residual", x.residual), f("solve_ms", x.solve_ms);
  f("fitted_cell_mm", x.fitted_cell_mm), f("distance_mm", x.distance_mm), f("difference", x.difference);
}

/// error_goal: what came of `operate --error` (app/result/error_goal.h).
struct ResultGoalFigure {
  std::string name;
  Maybe value, error, allowed;
  bool met = false;
};
template <class F>
void fields(ResultGoalFigure& x, F&& f) {
  f("name", x.name), f("value", x.value), f("error", x.error), f("allowed", x.allowed), f("met", x.met);
}
struct ResultErrorGoal {
  Maybe share;
  bool met = false;
  std::string why;
  std::vector<ResultGoalFigure> figures;
};
template <class F>
void fields(ResultErrorGoal& x, F&& f) {
  f("share", x.share), f("met", x.met), f("why", x.why), f("figures", x.figures);
}

/// discretisation/NAME: the lattice's share of a figure's error (sim/measure/extrapolation.h).
struct ResultError {
  Maybe value, error, order, extrapolated;
  bool asymptotic = false;
  std::string says;
};
template <class F>
void fields(ResultError& x, F&& f) {
  f("value", x.value), f("error", x.error), f("order", x.order), f("extrapolated", x.extrapolated);
  f("asymptotic", x.asymptotic), f("says", x.says);
}

/// bars of a study or a bench: the limit and the value. A value that is not there is not a number.
struct Bar {
  std::string name;
  double value = std::numeric_limits<double>::quiet_NaN();
  bool at_least = false;  // the true value is at least this one
  double bar = std::numeric_limits<double>::quiet_NaN();
  bool larger_is_better = false, pass = false;
  std::string source;  // where the bar comes from
};
template <class F>
void fields(Bar& x, F&& f) {
  f("name", x.name), f("value", x.value), f("at_least", x.at_least), f("bar", x.bar);
  f("larger_is_better", x.larger_is_better), f("pass", x.pass), f("source", x.source);
}

struct ResultMark {
  double value = std::numeric_limits<double>::quiet_NaN();
  std::string label;
};
template <class F>
void fields(ResultMark& x, F&& f) {
  f("value", x.value), f("label", x.label);
}

/// charts; x_marks and y_marks: lines at values worth comparing with.
struct ResultChart {
  struct Series {
    std::string name;
    std::vector<double> x, y;
    bool markers = false;
  };
  std::string title, description, x, y;
  bool x_log = false, y_log = false;
  std::vector<Series> series;
  std::vector<ResultMark> x_marks, y_marks;
};
template <class F>
void fields(ResultChart::Series& x, F&& f) {
  f("name", x.name), f("markers", x.markers), f("x", x.x), f("y", x.y);
}
template <class F>
void fields(ResultChart& x, F&& f) {
  f("title", x.title), f("description", x.description), f("x", x.x), f("y", x.y), f("x_log", x.x_log);
  f("y_log", x.y_log), f("series", x.series), f("x_marks", x.x_marks), f("y_marks", x.y_marks);
}

/// A struct that has its fields() above.
template <class T>
concept ResultEntry = requires(T& t) {
  fields(t, [](const char*, auto&) {});
};

/// Writes an entry, its lists included, at `path` ("/bars/0").
template <ResultEntry T>
void write_fields(Result& r, const std::string& path, const T& entry);

namespace schema {

template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;
template <class T>
inline constexpr bool is_list = false;
template <class T>
inline constexpr bool is_list<std::vector<T>> = true;
template <class T, size_t n>
inline constexpr bool is_list<std::array<T, n>> = true;

template <class T>
void write(Result& r, const std::string& path, const T& v) {
  if constexpr (ResultEntry<T>) {
    write_fields(r, path, v);
  } else if constexpr (std::is_same_v<T, MaybeText>) {
    if (v) r.set(path, *v);
  } else if constexpr (is_optional<T>) {
    if (v) write(r, path, *v);
  } else if constexpr (std::is_same_v<T, std::string>) {
    if (!v.empty()) r.set(path, v);
  } else if constexpr (std::is_same_v<T, std::vector<double>>) {
    const std::vector<float> shown(v.begin(), v.end());
    r.set(path, std::span<const float>(shown));
  } else if constexpr (is_list<T>) {
    r.set_empty_list(path);
    for (size_t i = 0; i < v.size(); ++i) {
      const std::string at = path + "/" + std::to_string(i);
      if constexpr (std::is_same_v<T, std::vector<std::string>>)
        r.set(at, v[i]);  // an empty text too: places in a list count
      else
        write(r, at, v[i]);
    }
  } else {
    r.set(path, v);
  }
}

}  // namespace schema

template <ResultEntry T>
void write_fields(Result& r, const std::string& path, const T& entry) {
  fields(const_cast<T&>(entry),  // fields() serves reading too; nothing is changed here
         [&](const char* name, const auto& v) { schema::write(r, path + "/" + name, v); });
}
/// Appends an entry to the list at `path`.
template <ResultEntry T>
void append(Result& r, const std::string& path, const T& entry) {
  write_fields(r, path + "/" + std::to_string(r.entries(path)), entry);
}

}  // namespace limberg
