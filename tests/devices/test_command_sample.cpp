// Commands of panels and programs on their way: through messages, recordings and the hand to the solver's side.
#include <gtest/gtest.h>

#include <filesystem>

#include "devices/command_builder.h"
#include "devices/gestures.h"
#include "devices/message_codec.h"
#include "devices/recording.h"
#include "sim/base/error.h"
#include "sim/commands/actions.h"
#include "sim/commands/script.h"
#include "tests/devices/flat_patient.h"

namespace limberg {
namespace test_command_sample {

using namespace test;

std::vector<Command> one_of_each() {
  std::vector<Command> all;
  for (const ActionLine& a : action_lines()) all.push_back(parse_command(a.example, "example", 1));
  return all;
}

TEST(CommandSample, EveryActGoesThroughAMessageAsItIs) {
  for (const Command& c : one_of_each()) {
    CommandSample s = command_sample(c), back;
    s.device_id = 50, s.seq = 3, s.t_ns = 12'345;
    MessageBytes bytes;
    const size_t n = encode_message(to_message(s), bytes);
    ASSERT_GT(n, 48u);
    limberg_msg::command_t m;
    bool has_checksum = false;
    ASSERT_EQ(decode_message(bytes.data(), n, m, &has_checksum), nullptr) << to_json_line(c);
    EXPECT_TRUE(has_checksum);
    ASSERT_EQ(to_sample(m, back), nullptr);
    EXPECT_EQ(to_json_line(*back.command), to_json_line(c));
    EXPECT_EQ(back.device_id, 50);
    EXPECT_EQ(back.seq, 3);
    EXPECT_EQ(back.t_ns, 12'345);
    // Neither shorter nor longer, nor with a length that is not there, nor with a bit changed.
    for (const size_t wrong : {size_t(0), size_t(8), size_t(43), n - 1, n + 1})
      EXPECT_NE(decode_message(bytes.data(), wrong, m), nullptr) << wrong;
    for (const int32_t length : {-1, 0, int32_t(kMaxCommandLine) + 1, INT32_MAX, INT32_MIN}) {
      MessageBytes lying = bytes;
      put_big_endian<int32_t>(lying.data() + 40, length);
      EXPECT_NE(decode_message(lying.data(), n, m), nullptr) << length;
    }
    MessageBytes changed = bytes;
    changed[n - 10] ^= 1;
    EXPECT_NE(decode_message(changed.data(), n, m), nullptr);
  }
}

TEST(CommandSample, WhatNoScriptCanHoldIsRefused) {
  limberg_msg::command_t m{};
  CommandSample s;
  for (const std::string line : {"", "{}", "{\"action\":\"dance\"}", "{\"action\":\"wait\",\"seconds\":-1}"}) {
    m.line.assign(line.begin(), line.end()), m.n = int32_t(line.size());
    EXPECT_NE(to_sample(m, s), nullptr) << line;
  }
  EXPECT_THROW(command_sample(Stage{""}), InputError);
  CutBone dense;
  for (int i = 0; i < 1000; ++i) dense.contour_mm.emplace_back(0.1 * i, 1.0 / 3, i);
  EXPECT_THROW(command_sample(HeadCommand(dense)), InputError);  // too long for a message
}

TEST(CommandSample, IsRecordedAndReadBack) {
  const std::string path = std::string(::testing::TempDir()) + "/limberg_command_sample.lcm";
  std::filesystem::remove(path);
  std::vector<std::string> lines;
  {
    RecordingWriter w;
    w.open(path, {}, {});
    for (const Command& c : one_of_each()) {
      CommandSample s = command_sample(c);
      s.seq = int64_t(lines.size()), s.t_ns = s.seq * 1'000'000;
      w.on_sample(s);
      lines.push_back(to_json_line(c));
    }
    EXPECT_TRUE(w.finish(100, 7));
  }
  const Recording r = read_recording(path);
  EXPECT_EQ(r.damage.total(), 0) << r.damage.first_message;
  ASSERT_EQ(r.samples.size(), lines.size());
  for (size_t i = 0; i < lines.size(); ++i)
    EXPECT_EQ(to_json_line(*std::get<CommandSample>(r.samples[i]).command), lines[i]);
  std::filesystem::remove(path);
}

TEST(CommandSample, PassesTheHandAndBreaksOffWhatItDoes) {
  const Snapshot s = snapshot_of(flat_topology(40, 1));
  for (const Command& c : one_of_each()) {
    Gestures g;
    CommandBuilder builder;
    Events out;
    ControlSample scalpel;
    scalpel.tool = Tool::scalpel;
    g.control(scalpel, 0, s, out);
    Pose p;
    p.valid = true;
    for (int i = 1; i < 40; ++i) p.tip_mm = {0.2 * i, 0, 0}, g.tick(i, p, true, 0, s, out);
    out.all.clear();
    const CommandSample sample = command_sample(c);
    g.command(sample.command, 50, s, out);
    const auto* of_head = std::get_if<HeadCommand>(&c);
    const bool leaves =
        of_head && (std::holds_alternative<PlaceLandmark>(*of_head) ||
                    std::holds_alternative<ConnectTissue>(*of_head) || std::holds_alternative<Superpose>(*of_head));
    ASSERT_EQ(out.all.size(), leaves ? 1u : 2u) << to_json_line(c);
    if (!leaves) {
      EXPECT_EQ(out.all[0].kind, ToolEvent::stroke_cancel);
    }
    EXPECT_EQ(out.all.back().kind, ToolEvent::told);
    const auto made = builder.feed(out.all.back());
    ASSERT_TRUE(made);
    EXPECT_EQ(to_json_line(*made), to_json_line(c));
  }
}

}  // namespace test_command_sample
}  // namespace limberg
