#include "devices/fastrak/port.h"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <thread>

#include "devices/monotonic.h"
#include "sim/base/error.h"

namespace limberg::fastrak {

namespace {

struct Rate {
  int baud;
  speed_t code;
};
constexpr Rate kRates[] = {{2400, B2400},   {4800, B4800},   {9600, B9600},    {19200, B19200},
                           {38400, B38400}, {57600, B57600}, {115200, B115200}};

}  // namespace

bool known_baud(int baud) {
  for (const Rate& r : kRates)
    if (r.baud == baud) return true;
  return false;
}

bool SerialPort::open(const std::string& path, int baud) {
  close();
  const Rate* rate = nullptr;
  for (const Rate& r : kRates)
    if (r.baud == baud) rate = &r;
  if (!rate) return why_ = "no rate of the device", false;
  fd_ = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0) return why_ = std::strerror(errno), false;
  termios t{};
  if (tcgetattr(fd_, &t) != 0) {
    why_ = "not a serial port";
    close();
    return false;
  }
  cfmakeraw(&t);
  t.c_cflag |= CLOCAL | CREAD;
  t.c_cflag &= tcflag_t(~(CRTSCTS | CSTOPB | PARENB));
  cfsetispeed(&t, rate->code);
  cfsetospeed(&t, rate->code);
  if (tcsetattr(fd_, TCSANOW, &t) != 0 || flock(fd_, LOCK_EX | LOCK_NB) != 0) {
    why_ = errno == EWOULDBLOCK ? "another program has it open" : std::strerror(errno);
    close();
    return false;
  }
  tcflush(fd_, TCIOFLUSH);
  why_.clear();
  return true;
}

void SerialPort::close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

int SerialPort::read(uint8_t* bytes, size_t most, int wait_ms) {
  if (fd_ < 0) return -1;
  pollfd p{fd_, POLLIN, 0};
  const int ready = ::poll(&p, 1, wait_ms);
  if (ready == 0 || (ready < 0 && errno == EINTR)) return 0;
  if (ready < 0) return -1;
  if (!(p.revents & POLLIN)) return -1;  // hung up or broken, with nothing left to read
  const ssize_t n = ::read(fd_, bytes, most);
  if (n > 0) return int(n);
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
  why_ = n == 0 ? "the line has ended" : std::strerror(errno);
  return -1;
}

bool SerialPort::write(const uint8_t* bytes, size_t n) {
  for (int tries = 0; n > 0 && fd_ >= 0 && tries < 50; ++tries) {
    const ssize_t k = ::write(fd_, bytes, n);
    if (k > 0) {
      bytes += k;
      n -= size_t(k);
    } else if (k < 0 && errno != EAGAIN && errno != EINTR) {
      return why_ = std::strerror(errno), false;
    } else {
      pollfd p{fd_, POLLOUT, 0};
      ::poll(&p, 1, 10);
    }
  }
  return fd_ >= 0;
}

struct EmulatedPort::Impl {
  Impl(Motion motion, const EmulatorSettings& settings)
      : device(std::move(motion), settings), start_ns(monotonic_ns()) {}

  void lay_line() {
    int slave = -1;
    char name[128];
    if (openpty(&master, &slave, name, nullptr, nullptr) != 0)
      throw InputError(
          "", 0,
          std::string("no pseudo-terminal to be had (") + std::strerror(errno) + "); expected a mounted /dev/pts");
    termios t{};
    tcgetattr(slave, &t);
    cfmakeraw(&t);
    tcsetattr(slave, TCSANOW, &t);
    path = name;
    fcntl(master, F_SETFL, fcntl(master, F_GETFL) | O_NONBLOCK);
    fcntl(master, F_SETFD, FD_CLOEXEC);
    keep = slave;  // held open, so that the line outlives whoever closes it
    fcntl(keep, F_SETFD, FD_CLOEXEC);
  }
  void take_line() {
    if (master >= 0) ::close(master);
    if (keep >= 0) ::close(keep);
    master = keep = -1;
  }

  void serve() {
    while (!stop.load()) {
      {
        const std::lock_guard lock(mutex);
        if (master >= 0) {
          uint8_t bytes[256];
          const int64_t now = monotonic_ns() - start_ns;
          for (ssize_t n; (n = ::read(master, bytes, sizeof bytes)) > 0;) device.receive(bytes, size_t(n), now);
          const std::vector<uint8_t> out = device.send(now);
          // A line that nobody empties loses bytes, as a real one does.
          if (!out.empty() && ::write(master, out.data(), out.size()) < 0 && errno != EAGAIN) continue;
        }
      }
      const timespec pause{0, 1'000'000};
      nanosleep(&pause, nullptr);
    }
  }

  Emulator device;
  const int64_t start_ns;
  std::mutex mutex;
  int master = -1, keep = -1;
  std::string path;
  std::atomic<bool> stop{false};
  std::thread thread;
};

EmulatedPort::EmulatedPort(Motion motion, const EmulatorSettings& settings)
    : impl_(std::make_unique<Impl>(std::move(motion), settings)) {
  impl_->lay_line();
  impl_->thread = std::thread([this] { impl_->serve(); });
}

EmulatedPort::~EmulatedPort() {
  impl_->stop = true;
  impl_->thread.join();
  impl_->take_line();
}

const std::string& EmulatedPort::path() const { return impl_->path; }
int64_t EmulatedPort::now_ns() const { return monotonic_ns() - impl_->start_ns; }

void EmulatedPort::unplug() {
  const std::lock_guard lock(impl_->mutex);
  impl_->take_line();
}
void EmulatedPort::plug_in() {
  const std::lock_guard lock(impl_->mutex);
  if (impl_->master < 0) impl_->lay_line();
}

}  // namespace limberg::fastrak
