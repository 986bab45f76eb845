#pragma once
// A sampled study: members drawn from what is not known of a tissue instead of every combination of values, and what
// they came to: a band for each figure, and each parameter's share of its variance.
#include <string>
#include <vector>

#include "app/result/uncertainty_result.h"
#include "app/study/ranges.h"
#include "app/study/sampling.h"
#include "app/study/study.h"

namespace limberg::study {

/// One combination of what is not sampled, with the members of the whole design.
struct SampledCase {
  std::string setting;            // "flap_angle 60"; empty when there is one case only
  std::vector<size_t> member_of;  // per point of the design
};

struct SampledStudy {
  Ranges ranges;  // of what is sampled: a parameter that --set names is not
  SampleKind kind = SampleKind::sobol;
  uint64_t seed = 0;
  Design design;
  std::vector<SampledCase> cases;
  std::vector<Values> members;  // of all cases, each once, in the order in which they are first met
};

/// `settings` as of --set: what they name keeps its values and is not sampled. Values have five digits, so that they
/// are the same on every machine. InputError: as members(); nothing left to sample; too many members.
SampledStudy sampled_study(const Family& family, const std::vector<std::string>& settings, const Ranges& ranges,
                           SampleKind kind, size_t n, uint64_t seed, bool sensitivity);

/// `rows` of the members that are done; `row_of`: per row its member.
ResultUncertainty uncertainty_of(const SampledStudy& study, const Family& family, const std::vector<Row>& rows,
                                 const std::vector<size_t>& row_of);

/// Per figure that the study is about, the share of members below each value, a line for each case.
std::vector<NamedChart> spread_charts(const SampledStudy& study, const Family& family, const std::vector<Row>& rows,
                                      const std::vector<size_t>& row_of);

}  // namespace limberg::study
