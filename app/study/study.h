#pragma once
// Studies: a family of operations, each member brought to equilibrium, with a row of figures for each, charts, and bars
// where theory or symmetry says what must come out.
//
//   limberg study gape --set angle_deg=90,45 --set prestretch_percent=5,10,20
//
// A family names its parameters, each with the values it takes by itself and the range that
// makes sense; --set gives others. Its members are all combinations, the first parameter
// changing slowest. Each is a process of its own (processes.h) that leaves a file
// (member_file.h); rows, charts and bars are made from the member files, of whichever machine.
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/report/svg_chart.h"
#include "app/result/schema.h"
#include "sim/base/workers.h"
#include "sim/patient/snapshot.h"

namespace limberg::study {

struct Parameter {
  std::string name, help;
  std::vector<double> values;  // by itself
  double lo = 0, hi = 0;       // what it may be
};

/// One member's values, in the order of the family's parameters.
using Values = std::vector<double>;

struct Row {
  std::vector<std::pair<std::string, double>> figures;  // the set values first
  ChartSeries profile;                                  // a curve of this member for the family's charts; may be empty
  std::string title;                                    // of its picture; empty: none is made
  std::shared_ptr<const Snapshot> shown;                // what is pictured
  double at(const std::string& name) const;             // not a number when there is none
};

struct NamedChart {
  std::string name, title;  // name: of its file
  LineChart chart;
};

struct Run {
  Workers& workers;
  std::function<bool()> interrupted;
};

/// Members of a family that a check needs.
struct CheckPart {
  std::string family;
  std::vector<std::string> settings;  // as of --set
};

struct Family {
  std::string name, about;
  std::vector<Parameter> parameters;
  std::function<Row(const Values&, const Run&)> run;
  std::function<std::vector<Bar>(const std::vector<Row>&)> bars;
  std::function<std::vector<NamedChart>(const std::vector<Row>&)> charts;
  // the members that all its checks need, its own first; empty: its members by themselves
  std::vector<CheckPart> check = {};
  std::function<uint64_t(const Values&)> inputs = {};  // hash of the files that a member reads; empty: it reads none
  std::vector<std::string> outcomes = {};              // figures that a sampled study is about; empty: all
};

Family gape();
Family stitches();
Family disc();
const std::vector<Family>& families();
/// InputError that lists the families when there is none of this name.
const Family& find_family(const std::string& name);

/// Of one study; a file for each lies in one folder.
inline constexpr size_t kMostMembers = 20'000;

/// The parameter that a key of --set means, empty when there is none.
std::string parameter_named(const Family& family, const std::string& key);

/// Applies "key=v1,v2,..." settings and lists the members; a key may leave its unit off (cell for cell_mm). InputError
/// on an unknown or repeated key, no or broken numbers, values
/// out of range, or more than kMostMembers.
std::vector<Values> members(const Family& family, const std::vector<std::string>& settings);

Bar at_most(std::string name, double value, double bar, std::string source);
Bar at_least(std::string name, double value, double bar, std::string source);

/// The rows as comma-separated values with a line of names.
std::string csv(const std::vector<Row>& rows);

}  // namespace limberg::study
