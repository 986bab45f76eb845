#pragma once
// Arrays of Limberg's as NumPy arrays that own nothing: they look into the object that has them, and keep it alive.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <span>
#include <vector>

#include "sim/base/shared_array.h"

namespace limberg::python {

namespace py = pybind11;

/// A read-only view of memory that `owner` keeps. Strides in bytes.
template <class T>
py::array view(const T* data, std::vector<py::ssize_t> shape, std::vector<py::ssize_t> strides, py::handle owner) {
  py::array a(py::dtype::of<T>(), std::move(shape), std::move(strides), data, owner);
  py::detail::array_proxy(a.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return a;
}

/// (n,) of a list of numbers.
template <class T>
py::array view_list(const std::vector<T>& v, py::handle owner) {
  return view(v.data(), {py::ssize_t(v.size())}, {py::ssize_t(sizeof(T))}, owner);
}
/// (n, K) of a list of rows that hold K numbers of type T each, one after the other.
template <class T, int K, class Row>
py::array view_rows(const std::vector<Row>& v, py::handle owner) {
  static_assert(sizeof(Row) == K * sizeof(T));
  return view(reinterpret_cast<const T*>(v.data()), {py::ssize_t(v.size()), K},
              {py::ssize_t(sizeof(Row)), py::ssize_t(sizeof(T))}, owner);
}
/// (n,) of one member of a list of structs.
template <class T, class Row>
py::array view_member(const std::vector<Row>& v, T Row::*member, py::handle owner) {
  return view(v.empty() ? nullptr : &(v.data()->*member), {py::ssize_t(v.size())}, {py::ssize_t(sizeof(Row))}, owner);
}

/// (n, K) copied: what lies in chunks (sim/base/shared_array.h) is no one array.
template <class T, int K, class Row>
py::array copy_rows(const SharedArray<Row>& v) {
  py::array_t<T> out({py::ssize_t(v.size()), py::ssize_t(K)});
  T* to = out.mutable_data();
  for (const Row& row : v)
    for (int k = 0; k < K; ++k) *to++ = T(row[size_t(k)]);
  return out;
}

}  // namespace limberg::python
