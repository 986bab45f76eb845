// Reading: every step is bounded by the bytes that are there, and each search moves on over what it has looked at, so
// that the work is linear in the size of the file whatever it holds.

#include <cstring>

#include "devices/big_endian.h"
#include "devices/lcm_log.h"
#include "sim/base/whole_file.h"

namespace limberg {

LogReader::LogReader(const std::string& path)
    : bytes_(read_whole_file<std::vector<uint8_t>>(path, kMaxFile, "an LCM event log")) {}

LogReader::Look LogReader::look_at(size_t at, LogEvent& e) const {
  const size_t left = bytes_.size() - at;
  const uint8_t* p = bytes_.data() + at;
  if (left < 4) return Look::beyond_end;
  if (get_big_endian<uint32_t>(p) != kSync) return Look::not_sync;
  if (left < kHeader) return Look::beyond_end;
  const auto channel = get_big_endian<uint32_t>(p + 20), data = get_big_endian<uint32_t>(p + 24);
  if (channel == 0 || channel > kMaxChannel || data > kMaxData) return Look::bad_length;
  if (left < kHeader + channel + data) return Look::beyond_end;
  for (uint32_t i = 0; i < channel; ++i)
    if (p[kHeader + i] < 0x20) return Look::bad_length;
  e.number = get_big_endian<int64_t>(p + 4);
  e.time_us = get_big_endian<int64_t>(p + 12);
  e.offset = int64_t(at);
  e.channel = std::string_view(reinterpret_cast<const char*>(p + kHeader), channel);
  e.data = p + kHeader + channel;
  e.size = data;
  return Look::event;
}

/// A whole event that is followed by the end or by another sync word.
bool LogReader::plausible(size_t at) const {
  LogEvent e;
  if (look_at(at, e) != Look::event) return false;
  const size_t after = size_t(e.data - bytes_.data()) + e.size;
  if (after == bytes_.size()) return true;
  return bytes_.size() - after < 4 || get_big_endian<uint32_t>(bytes_.data() + after) == kSync;
}

/// The first plausible event that begins in [from, to); bytes_.size() when there is none.
size_t LogReader::find_plausible(size_t from, size_t to) const {
  for (size_t at = from; at < to;) {
    const void* hit = std::memchr(bytes_.data() + at, 0xED, to - at);
    if (!hit) break;
    at = size_t(static_cast<const uint8_t*>(hit) - bytes_.data());
    if (plausible(at)) return at;
    ++at;
  }
  return bytes_.size();
}

void LogReader::note(const char* what, size_t offset) {
  if (damage_.first_message.empty()) damage_.first_message = std::string(what) + " at byte " + std::to_string(offset);
}

/// Event numbers grow by one. A jump that the next number takes back was damage to the number itself, not a loss.
void LogReader::check_number(int64_t number) {
  constexpr int64_t kMostMissing = LogDamage::kMostMissing;
  if (number == expected_) {
    jump_ = 0;
  } else if (jump_ != 0 && number == expected_ - jump_) {
    if (jump_ > 0 && jump_ < kMostMissing) damage_.missing -= jump_;
    jump_ = 0;
  } else if (number >= 0 && number < INT64_MAX / 2) {
    jump_ = number - expected_;
    if (jump_ > 0 && jump_ < kMostMissing) damage_.missing += jump_;
  } else {
    ++expected_;  // not a number: as if it had been the right one
    return;
  }
  expected_ = number + 1;
}

bool LogReader::next(LogEvent& e) {
  while (at_ < bytes_.size()) {
    const Look look = look_at(at_, e);
    size_t resume = 0;
    if (look == Look::event) {
      const size_t after = size_t(e.data - bytes_.data()) + e.size;
      if (after == bytes_.size() || plausible(at_)) {
        check_number(e.number);
        at_ = after;
        return true;
      }
      // What follows is not an event. Either that one is damaged, or this one's length is and swallows whole events.
      resume = find_plausible(at_ + kHeader, after);
      if (resume == bytes_.size()) {
        check_number(e.number);
        at_ = after;
        return true;
      }
      ++damage_.bad_length;
      note("an event's length runs over the next event", at_);
    } else {
      resume = find_plausible(at_ + 1, bytes_.size());
      if (look == Look::beyond_end && resume == bytes_.size()) {
        ++damage_.truncated;
        note("the file ends within an event", at_);
      } else if (look == Look::not_sync) {
        ++damage_.bad_sync;
        note("no event begins", at_);
      } else {
        ++damage_.bad_length;
        note("an event's channel or data length cannot be", at_);
      }
    }
    damage_.skipped_bytes += int64_t(resume - at_);
    at_ = resume;
  }
  return false;
}

}  // namespace limberg
