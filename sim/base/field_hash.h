#pragma once
// The hash of a plain struct, field by field.
//
//   template <class V> void fields(const Hook& hook, V&& v) {
//     const auto& [id, at_mm] = hook;      // a field that is added and not named here does not compile
//     v(id, at_mm);
//   }
//   FieldHash h;  h(hook);  h.value();
//
// fields() is found beside the struct. Lists count their length, optional values whether they are there.
#include <array>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "sim/base/hash.h"

namespace limberg {

class FieldHash {
 public:
  template <class... T>
  requires(sizeof...(T) != 1) void operator()(const T&... field) { (add(field), ...); }
  template <class T>
  void operator()(const T& field) {
    add(field);
  }
  uint64_t value() const { return h_.value(); }

 private:
  template <class T>
  void add(const T& v) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T> || std::is_same_v<T, std::string>)
      h_.add(v);
    else if constexpr (requires { typename T::Scalar; })  // a vector or matrix of Eigen
      h_.bytes(v.data(), size_t(v.size()) * sizeof(typename T::Scalar));
    else
      fields(v, *this);
  }
  template <class T>
  void add(const std::optional<T>& v) {
    h_.add(v.has_value());
    if (v) add(*v);
  }
  template <class T, size_t N>
  void add(const std::array<T, N>& list) {
    for (const T& v : list) add(v);
  }
  template <class T>
  void add(const std::vector<T>& list) {
    h_.add(uint64_t(list.size()));
    if constexpr (std::is_arithmetic_v<T>)
      h_.bytes(list.data(), list.size() * sizeof(T));
    else
      for (const T& v : list) add(v);
  }

  Hash64 h_;
};

}  // namespace limberg
