#include "app/pictures/film.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <vector>

#include "app/pictures/pictures.h"
#include "app/result/output.h"
#include "app/session/belt.h"
#include "app/session/clock.h"
#include "render/picture.h"
#include "sim/base/error.h"

extern char** environ;

namespace limberg {

namespace fs = std::filesystem;

namespace {

// The codec's options by the film's ending; empty: unknown.
std::vector<std::string> codec(const std::string& ending) {
  if (ending == ".mp4")
    return {"-c:v",     "libx264", "-preset",   "veryfast",   "-crf", "20",
            "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f",   "mp4"};
  if (ending == ".webm")
    return {"-c:v", "libvpx-vp9", "-deadline", "realtime", "-cpu-used", "8",  "-crf",
            "32",   "-b:v",       "0",         "-pix_fmt", "yuv420p",   "-f", "webm"};
  return {};
}

/// A running ffmpeg that takes raw frames on its standard input.
struct Encoder {
  pid_t child = -1;
  int to = -1;

  void start(const std::vector<std::string>& words) {
    int pipe_ends[2];
    if (pipe2(pipe_ends, O_CLOEXEC) != 0)
      throw InputError("ffmpeg", 0, std::string("no pipe: ") + std::strerror(errno) + "; expected one");
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, pipe_ends[0], 0);
    posix_spawn_file_actions_addopen(&files, 1, "/dev/null", O_WRONLY, 0);
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    posix_spawnattr_t
        alone;  // in a process group of its own: Ctrl-C on a terminal must not reach it before the last frame
    posix_spawnattr_init(&alone);
    posix_spawnattr_setflags(&alone, POSIX_SPAWN_SETPGROUP);
    const int failed = posix_spawnp(&child, "ffmpeg", &files, &alone, arguments.data(), environ);
    posix_spawnattr_destroy(&alone);
    posix_spawn_file_actions_destroy(&files);
    ::close(pipe_ends[0]);
    if (failed) {
      ::close(pipe_ends[1]);
      child = -1;
      throw InputError("ffmpeg", 0,
                       std::string("cannot be run: ") + std::strerror(failed) +
                           "; expected it to be installed (Debian: apt-get install ffmpeg)");
    }
    to = pipe_ends[1];
    fcntl(to, F_SETPIPE_SZ, 1 << 20);  // fewer turns to and fro for a frame of megabytes; refused, it is as it was
  }
  bool write(const uint8_t* bytes, size_t n) {
    while (n > 0) {
      const ssize_t w = ::write(to, bytes, n);
      if (w < 0 && errno == EINTR) continue;
      if (w <= 0) return false;
      bytes += w, n -= size_t(w);
    }
    return true;
  }
  /// Its exit status once everything is written; -1 when it never ran.
  int stop() {
    if (to >= 0) ::close(to), to = -1;
    if (child < 0) return -1;
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    child = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  }
};

}  // namespace

namespace {

/// What a frame shows; without it, it is the frame before once more.
struct Shot {
  std::optional<Snapshot> patient;
  PictureOptions options;
};

}  // namespace

struct Film::Impl {
  FilmSettings set;
  std::string part;  // the film until it is whole
  Camera camera;
  Encoder encoder;
  std::string title;
  SecondHand glove, other_glove;
  bool new_title = false, any = false, closed = false;
  std::atomic<bool> broken{false};

  // Of the drawing thread, until it has ended.
  std::unique_ptr<PictureMaker> maker;
  Image shown;
  FilmTimes times;

  std::unique_ptr<Belt<Shot>> drawing;  // last: its thread uses the rest

  void draw(const Shot& shot);
  void hand_over(Shot shot);
};

Film::Film(const Scene& scene, const FilmSettings& settings) : impl_(new Impl) {
  Impl& i = *impl_;
  i.set = settings;
  i.camera = scene_camera(scene);
  const std::vector<std::string> coded = codec(fs::path(settings.file).extension().string());
  if (coded.empty())
    throw InputError(settings.file, 0, "not a kind of film that is known; expected a name that ends in .mp4 or .webm");
  check_writable(settings.file);
  i.part = settings.file + "." + std::to_string(getpid()) + ".part";  // two processes may write into one folder
  signal(SIGPIPE, SIG_IGN);  // an encoder that ends early is seen by the failed write
  std::vector<std::string> words{"ffmpeg",
                                 "-loglevel",
                                 "error",
                                 "-nostdin",
                                 "-y",
                                 "-f",
                                 "rawvideo",
                                 "-pix_fmt",
                                 "rgb24",
                                 "-video_size",
                                 std::to_string(settings.width) + "x" + std::to_string(settings.height),
                                 "-framerate",
                                 std::to_string(settings.frames_per_s),
                                 "-i",
                                 "pipe:0"};
  words.insert(words.end(), coded.begin(), coded.end());
  words.push_back(i.part);
  i.encoder.start(words);
}

Film::~Film() {
  impl_->drawing.reset();
  if (impl_->closed) return;
  impl_->encoder.stop();
  std::error_code ec;
  fs::remove(impl_->part, ec);
}

void Film::prepare(const SurfaceTopology&) {
  Impl& i = *impl_;
  const auto begin = [&i] {
    i.maker = std::make_unique<PictureMaker>(i.set.width, i.set.height,
                                             i.set.fine ? PictureQuality::still : PictureQuality::film);
    i.maker->set_camera(i.camera);
  };
  i.drawing = std::make_unique<Belt<Shot>>(
      begin, [&i](Shot& shot) { i.draw(shot); }, [&i] { i.maker.reset(); });
}

void Film::second_hand(const SecondHand& hand, const SecondHand& other) {
  impl_->glove = hand, impl_->other_glove = other;
}

void Film::frame(const Snapshot& snapshot, const ToolState& tool) {
  Impl& i = *impl_;
  Shot shot{snapshot, {}};
  shot.options.tool = tool_pose(tool, i.glove, i.other_glove);
  shot.options.title = i.title;
  i.new_title = false, i.any = true;
  i.hand_over(std::move(shot));
}

void Film::same_frame() {
  if (impl_->any) impl_->hand_over({});
}

void Film::Impl::hand_over(Shot shot) {
  if (!broken && drawing) drawing->put(std::move(shot));
}

void Film::Impl::draw(const Shot& shot) {
  if (broken) return;
  const int64_t before = RealClock::monotonic_ns();
  if (shot.patient) shown = maker->skin(*shot.patient, shot.options), ++times.drawn;
  const int64_t drawn = RealClock::monotonic_ns();
  if (!encoder.write(shown.rgb.data(), shown.rgb.size()))
    broken = true;
  else
    ++times.frames;
  times.drawing_s += 1e-9 * double(drawn - before);
  times.encoding_s += 1e-9 * double(RealClock::monotonic_ns() - drawn);
}

bool Film::wants_frame() { return impl_->new_title; }

void Film::stage(const std::string& name, const Snapshot&) {
  impl_->title = picture_title(impl_->set.w, name), impl_->new_title = true;
}

bool Film::open() const { return !impl_->broken; }

void Film::finish() {
  if (impl_->drawing) impl_->drawing->stop();
}

void Film::close() {
  Impl& i = *impl_;
  const int64_t before = RealClock::monotonic_ns();
  const int status = i.encoder.stop();
  i.times.encoding_s += 1e-9 * double(RealClock::monotonic_ns() - before);
  if (status != 0 || i.broken || i.times.frames == 0) {
    std::error_code ec;
    fs::remove(i.part, ec);
    i.closed = true;
    throw InputError(i.set.file, 0,
                     "the film was not made: ffmpeg ended with status " + std::to_string(status) + " after " +
                         std::to_string(i.times.frames) +
                         " frames; expected a disk with room and an ffmpeg with the codec for this ending");
  }
  i.closed = true;
  std::error_code why;
  fs::rename(i.part, i.set.file, why);
  if (!why) return;
  std::error_code ec;
  fs::remove(i.part, ec);
  throw InputError(i.set.file, 0, "cannot be written (" + why.message() + "); expected a folder that takes files");
}

const FilmTimes& Film::times() const { return impl_->times; }

}  // namespace limberg
