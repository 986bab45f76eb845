#pragma once
// Structs of a result (schema.h, run_result.h) back from JSON, without trust: what is absent or of another kind leaves
// the value as it is (empty). Written and read by the same fields().
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "app/result/schema.h"

namespace limberg::result_json {

using Json = nlohmann::json;

/// The member, or null when j is no object or has none.
inline const Json& member(const Json& j, const char* name) {
  static const Json nothing;
  if (!j.is_object()) return nothing;
  const auto it = j.find(name);
  return it == j.end() ? nothing : *it;
}

inline Maybe number(const Json& j) {
  return j.is_number() && std::isfinite(j.get<double>()) ? Maybe(j.get<double>()) : Maybe();
}

/// Words or a number as words; never a structure.
inline std::string words(const Json& j) {
  if (j.is_string()) return j.get<std::string>();
  return j.is_number() || j.is_boolean() ? j.dump() : std::string();
}

template <class T>
void read(const Json& j, T& v) {
  if constexpr (ResultEntry<T>) {
    fields(v, [&](const char* name, auto& x) { read(member(j, name), x); });
  } else if constexpr (std::is_same_v<T, Maybe>) {
    v = number(j);
  } else if constexpr (std::is_same_v<T, MaybeCount>) {
    if (j.is_number_integer()) v = j.get<int64_t>();
  } else if constexpr (std::is_same_v<T, MaybeFlag>) {
    if (j.is_boolean()) v = j.get<bool>();
  } else if constexpr (std::is_same_v<T, MaybeText>) {
    if (j.is_primitive() && !j.is_null()) v = words(j);
  } else if constexpr (schema::is_optional<T>) {
    if (!j.is_null()) read(j, v.emplace());
  } else if constexpr (std::is_same_v<T, double>) {
    v = number(j).value_or(v);
  } else if constexpr (std::is_same_v<T, int64_t>) {
    if (j.is_number_integer()) v = j.get<int64_t>();
  } else if constexpr (std::is_same_v<T, bool>) {
    v = j.is_boolean() && j.get<bool>();
  } else if constexpr (std::is_same_v<T, std::string>) {
    v = words(j);
  } else if constexpr (std::is_same_v<T, ResultVector>) {
    for (size_t i = 0; i < v.size() && j.is_array() && j.size() == v.size(); ++i) v[i] = number(j[i]).value_or(v[i]);
  } else if constexpr (std::is_same_v<T, std::vector<double>>) {
    if (j.is_array())
      for (const Json& e : j) v.push_back(number(e).value_or(std::numeric_limits<double>::quiet_NaN()));
  } else {
    static_assert(schema::is_list<T>);
    if (!j.is_array()) return;
    for (const Json& e : j) {
      if (ResultEntry<typename T::value_type> && !e.is_object()) continue;
      read(e, v.emplace_back());
    }
  }
}

/// Every number of an object by its name.
inline void read(const Json& j, std::map<std::string, double>& numbers, const std::string& before = "") {
  if (!j.is_object()) return;
  for (const auto& [name, value] : j.items())
    if (const Maybe v = number(value)) numbers[before + name] = *v;
}

}  // namespace limberg::result_json
