#include "sim/fem/model/row_groups.h"

namespace limberg::fem {

RowGroups group_rows(int32_t rows, const int32_t* begin, const int32_t* column, const float* value) {
  RowGroups g;
  g.rows = rows;
  const size_t groups = size_t(rows + 3) / 4;
  g.begin.resize(groups + 1);
  std::vector<float> number;
  number.reserve(size_t(begin[rows]) + size_t(begin[rows]) / 4);
  g.base.reserve(size_t(begin[rows]) / 3);
  for (size_t k = 0; k < groups; ++k) {
    const int32_t r0 = int32_t(4 * k), count = rows - r0 < 4 ? rows - r0 : 4;
    int32_t at[4], end[4];
    for (int32_t i = 0; i < 4; ++i)
      at[i] = begin[i < count ? r0 + i : rows], end[i] = i < count ? begin[r0 + i + 1] : at[i];
    for (;;) {  // the next diagonal of any of the rows
      int32_t base = INT32_MAX;
      for (int32_t i = 0; i < count; ++i)
        if (at[i] < end[i] && column[at[i]] - i < base) base = column[at[i]] - i;
      if (base == INT32_MAX) break;
      g.base.push_back(base);
      for (int32_t i = 0; i < 4; ++i)
        number.push_back(i < count && at[i] < end[i] && column[at[i]] - i == base ? value[at[i]++] : 0.0f);
    }
    g.begin[k + 1] = int32_t(g.base.size());
  }
  g.number.resize(number.size());
  if (!number.empty()) std::memcpy(g.number.data(), number.data(), number.size() * sizeof(float));
  return g;
}

}  // namespace limberg::fem
