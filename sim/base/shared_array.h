#pragma once
// An array whose copies share what they have in common.
//
// Every cut makes a new version of the lattice, the finite elements and the surface, and old
// versions stay: undo goes back to them, and other threads draw them. Most of a version is as
// it was. So big lists are kept in chunks of about two kilobytes; a copy of the array shares
// them all, and writing to an element first gives the writer a chunk of its own. Copying costs
// one counter per chunk, a change costs what it touches, and for readers it is an array.
//
//   SharedArray<int> b = a;   b[7] = 1;   // a is as it was
//   for_each_change(a, b, [](size_t i) { ... });   // 7, at the cost of one chunk
//
// Elements are read by any number of threads. Writing is for the one thread that owns the
// array object; chunks that other arrays hold are never written. Reading through a
// non-const array makes chunks its own: loops that only read should name the array const.
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace limberg {

template <class T>
class SharedArray {
 public:
  static constexpr size_t kChunk = std::bit_floor(std::clamp<size_t>(2048 / sizeof(T), 4, 1024));
  using value_type = T;

  SharedArray() = default;
  SharedArray(const std::vector<T>& v) { assign(v.begin(), v.end()); }
  SharedArray(std::initializer_list<T> v) { assign(v.begin(), v.end()); }
  explicit SharedArray(size_t n, const T& value = T()) { resize(n, value); }

  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const T& operator[](size_t i) const { return chunk_[i / kChunk]->item[i % kChunk]; }
  T& operator[](size_t i) { return own(i / kChunk).item[i % kChunk]; }
  const T& front() const { return (*this)[0]; }
  const T& back() const { return (*this)[size_ - 1]; }
  /// Writes only what is not there already, so that equal versions go on sharing.
  void set(size_t i, const T& value) {
    if (!(std::as_const(*this)[i] == value)) (*this)[i] = value;
  }

  void push_back(const T& value) {
    if (size_ % kChunk == 0) chunk_.push_back(std::make_shared<Chunk>());
    own(size_ / kChunk).item[size_ % kChunk] = value;
    ++size_;
  }
  void resize(size_t n, const T& value = T()) {
    if (n <= size_) {
      size_ = n;
      chunk_.resize((n + kChunk - 1) / kChunk);
      return;
    }
    chunk_.reserve((n + kChunk - 1) / kChunk);
    while (size_ < n) push_back(value);
  }
  void clear() { resize(0); }
  void pop_back() { resize(size_ - 1); }
  void reserve(size_t n) { chunk_.reserve((n + kChunk - 1) / kChunk); }
  void assign(size_t n, const T& value) {
    clear();
    resize(n, value);
  }
  template <std::input_iterator It>
  void assign(It from, It to) {
    clear();
    for (; from != to; ++from) push_back(*from);
  }
  std::vector<T> flat() const { return {begin(), end()}; }
  operator std::vector<T>() const { return flat(); }

  template <class Array>
  class Iterator {
   public:
    using iterator_category = std::random_access_iterator_tag;
    using value_type = T;
    using difference_type = ptrdiff_t;
    using reference = decltype(std::declval<Array&>()[0]);
    using pointer = std::remove_reference_t<reference>*;
    Iterator() = default;
    Iterator(Array* a, size_t i) : a_(a), i_(i) {}
    reference operator*() const { return (*a_)[i_]; }
    pointer operator->() const { return &(*a_)[i_]; }
    reference operator[](ptrdiff_t d) const { return (*a_)[i_ + size_t(d)]; }
    Iterator& operator++() { return ++i_, *this; }
    Iterator& operator--() { return --i_, *this; }
    Iterator operator++(int) { return {a_, i_++}; }
    Iterator operator--(int) { return {a_, i_--}; }
    Iterator& operator+=(ptrdiff_t d) { return i_ += size_t(d), *this; }
    Iterator& operator-=(ptrdiff_t d) { return i_ -= size_t(d), *this; }
    friend Iterator operator+(Iterator p, ptrdiff_t d) { return p += d; }
    friend Iterator operator+(ptrdiff_t d, Iterator p) { return p += d; }
    friend Iterator operator-(Iterator p, ptrdiff_t d) { return p -= d; }
    friend ptrdiff_t operator-(const Iterator& p, const Iterator& q) { return ptrdiff_t(p.i_) - ptrdiff_t(q.i_); }
    bool operator==(const Iterator& o) const { return i_ == o.i_; }
    auto operator<=>(const Iterator& o) const { return i_ <=> o.i_; }

   private:
    Array* a_ = nullptr;
    size_t i_ = 0;
  };
  using const_iterator = Iterator<const SharedArray>;
  const_iterator begin() const { return {this, 0}; }
  const_iterator end() const { return {this, size_}; }
  Iterator<SharedArray> begin() { return {this, 0}; }
  Iterator<SharedArray> end() { return {this, size_}; }

  friend bool operator==(const SharedArray& a, const SharedArray& b) {
    bool same = a.size() == b.size();
    for (size_t c = 0; same && c < a.chunks(); ++c)
      same = a.shares(b, c) || std::equal(a.run(c), a.run(c) + a.run_length(c), b.run(c));
    return same;
  }

  // Chunk by chunk, for loops that compare versions or copy into flat arrays.
  size_t chunks() const { return chunk_.size(); }
  const T* run(size_t c) const { return chunk_[c]->item.data(); }
  size_t run_length(size_t c) const { return std::min(kChunk, size_ - c * kChunk); }
  bool shares(const SharedArray& other, size_t c) const {
    return c < other.chunks() && chunk_[c] == other.chunk_[c] && run_length(c) == other.run_length(c);
  }

 private:
  struct Chunk {
    std::array<T, kChunk> item{};
  };
  Chunk& own(size_t c) {
    std::shared_ptr<Chunk>& p = chunk_[c];
    if (p.use_count() != 1)
      p = std::make_shared<Chunk>(*p);
    else
      std::atomic_thread_fence(std::memory_order_acquire);  // whoever shared it last has finished reading
    return *p;
  }
  std::vector<std::shared_ptr<Chunk>> chunk_;
  size_t size_ = 0;
};

/// Calls visit(i) for every i of `now` at which `before` has no element or another one, ascending.
template <class T, class Visit>
void for_each_change(const SharedArray<T>& before, const SharedArray<T>& now, Visit&& visit) {
  for (size_t c = 0; c < now.chunks(); ++c) {
    if (now.shares(before, c)) continue;
    const size_t first = c * SharedArray<T>::kChunk, end = first + now.run_length(c);
    for (size_t i = first; i < end; ++i)
      if (i >= before.size() || !(before[i] == now[i])) visit(i);
  }
}

}  // namespace limberg
