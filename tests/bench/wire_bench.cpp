// Latency from the sender's send() to the subscriber's receive, through the real daemon and, in
// turn, through an echo loop with the same sockets and wait modes (echo.cpp). Other load on the
// machine affects both alike, so compare ratios, not microseconds. No assertions.
#include <sys/wait.h>
#include <unistd.h>
#include <zmq.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "proto/styled/v1/frame.pb.h"
#include "tests/support/daemon.h"
#include "tests/support/rig.h"

namespace styled::bench {
namespace {

using Clock = std::chrono::steady_clock;

struct Options {
  int performers = 1, subscribers = 1, rounds = 3, daemon_cpu = -1, priority = 0;
  double seconds = 4, rate_hz = 120;
  std::vector<std::string> only;
  std::string weights = STYLED_SOURCE_DIR "/model/weights/v2.safetensors", style = "elderly", json;
  std::string precision = "int8";
  std::string like;  // a clip
};

struct Variant {
  std::string name, wait;
  bool echo = false, prewarm = false, like = false, bundle = false;
};

// Over all rounds of one variant.
struct Result {
  std::vector<double> latency_us;
  std::uint64_t sent = 0, lost = 0;
  double cpu_us = 0;  // of the pipeline's thread
  std::uint64_t frames = 0;
  double rss_mb = 0;                        // at the end of the last round
  std::map<std::string, double> stages_us;  // summed over rounds
  int stage_rounds = 0;
  std::vector<double> like_ms;  // from the request to the reply
};

constexpr double kPeriod_us = 1e6 / 120;

std::int64_t Now_ns() { return Clock::now().time_since_epoch() / std::chrono::nanoseconds(1); }

// The CPU time of the pipeline's thread.
double PipelineCpu_us(pid_t pid) {
  for (const auto& task :
       std::filesystem::directory_iterator("/proc/" + std::to_string(pid) + "/task")) {
    std::string name;
    std::ifstream(task.path() / "comm") >> name;
    if (name != "pipeline") continue;
    double ns = 0;
    std::ifstream(task.path() / "schedstat") >> ns;
    return ns * 1e-3;
  }
  return 0;
}

double Rss_mb(pid_t pid) {
  std::ifstream statm("/proc/" + std::to_string(pid) + "/statm");
  double size = 0, resident = 0;
  statm >> size >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

// The echo loop as a child.
class EchoChild {
 public:
  EchoChild(const std::string& wait, int cpu, int priority) {
    int in[2], out[2];
    if (pipe(in) != 0 || pipe(out) != 0) std::abort();
    pid_ = fork();
    if (pid_ == 0) {
      dup2(in[0], STDIN_FILENO);
      dup2(out[1], STDOUT_FILENO);
      for (const int fd : {in[0], in[1], out[0], out[1]}) close(fd);
      execl(STYLED_ECHO, STYLED_ECHO, wait.c_str(), std::to_string(cpu).c_str(),
            std::to_string(priority).c_str(), nullptr);
      _exit(127);
    }
    close(in[0]);
    close(out[1]);
    in_ = in[1];
    FILE* const told = fdopen(out[0], "r");
    char udp_text[128], publish_text[128];
    if (std::fscanf(told, "%127s %127s", udp_text, publish_text) != 2) std::abort();
    std::fclose(told);
    udp = udp_text;
    publish = publish_text;
  }
  ~EchoChild() {
    close(in_);
    waitpid(pid_, nullptr, 0);
  }
  EchoChild(const EchoChild&) = delete;
  EchoChild& operator=(const EchoChild&) = delete;
  pid_t pid() const { return pid_; }
  std::string udp, publish;

 private:
  pid_t pid_;
  int in_;
};

// Makes a style of an example every second, whose first frame is the one after the reply.
class Examples {
 public:
  Examples(const std::string& control, const std::string& clip, std::vector<double>& took_ms)
      : took_ms_(took_ms), thread_([this, control, clip] { Run(control, clip); }) {}
  ~Examples() {
    stop_ = true;
    thread_.join();
  }
  Examples(const Examples&) = delete;
  Examples& operator=(const Examples&) = delete;

 private:
  void Run(const std::string& control, const std::string& clip) {
    support::ControlClient client(control);
    v1::Request request;
    std::ifstream file(clip, std::ios::binary);
    request.mutable_like()->mutable_clip()->assign(std::istreambuf_iterator<char>(file), {});
    request.mutable_like()->set_name("example");
    while (!stop_) {
      const std::int64_t begun_ns = Now_ns();
      const v1::Reply reply = client.Ask(request);
      if (reply.code() != v1::CODE_OK) {
        std::cerr << "like: " << reply.reason() << "\n";
        std::exit(1);
      }
      took_ms_.push_back(static_cast<double>(Now_ns() - begun_ns) * 1e-6);
      support::Sleep(1);
    }
  }
  std::vector<double>& took_ms_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

// Receives on a separate thread, as a renderer does.
class Listener {
 public:
  Listener(const std::string& endpoint, int performers, bool echo, bool bundle)
      : echo_(echo), bundle_(bundle) {
    context_ = zmq_ctx_new();
    socket_ = zmq_socket(context_, ZMQ_SUB);
    const int wait_ms = 50, room = 10000;
    zmq_setsockopt(socket_, ZMQ_RCVTIMEO, &wait_ms, sizeof wait_ms);
    zmq_setsockopt(socket_, ZMQ_RCVHWM, &room, sizeof room);
    if (bundle) zmq_setsockopt(socket_, ZMQ_SUBSCRIBE, "frames/rig/", 11);
    for (int i = 0; i < performers && !bundle; ++i) {
      const std::string topic = "styled/rig.p" + std::to_string(i) + "/rig/";
      zmq_setsockopt(socket_, ZMQ_SUBSCRIBE, topic.data(), topic.size());
    }
    if (zmq_connect(socket_, endpoint.c_str()) != 0) std::abort();
    latency_us.reserve(1 << 20);
    thread_ = std::thread([this] { Run(); });
  }
  ~Listener() { Stop(); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  void Stop() {
    if (!thread_.joinable()) return;
    stop_ = true;
    thread_.join();
    zmq_close(socket_);
    zmq_ctx_term(context_);
  }

  // Frames sent from then on are measured.
  std::atomic<std::int64_t> from_ns = std::numeric_limits<std::int64_t>::max();
  std::atomic<std::int64_t> to_ns = std::numeric_limits<std::int64_t>::max();
  std::vector<double> latency_us;  // valid after Stop

 private:
  void Run() {
    char topic[256];
    std::vector<char> payload(1 << 20);
    v1::Frame frame;
    v1::Frames frames;
    const auto note = [this](std::uint64_t sent_ns, std::int64_t now_ns) {
      const auto sent = static_cast<std::int64_t>(sent_ns);
      if (sent < from_ns || sent >= to_ns) return;
      latency_us.push_back(static_cast<double>(now_ns - sent) * 1e-3);
    };
    while (!stop_) {
      if (zmq_recv(socket_, topic, sizeof topic, 0) < 0) continue;
      const int size = zmq_recv(socket_, payload.data(), payload.size(), 0);
      const std::int64_t now_ns = Now_ns();
      if (echo_) {
        std::uint64_t sent_ns = 0;
        std::memcpy(&sent_ns, payload.data(), sizeof sent_ns);
        note(sent_ns, now_ns);
      } else if (bundle_) {
        frames.ParseFromArray(payload.data(), size);
        for (const auto& each : frames.frames()) note(each.source_time_ns(), now_ns);
      } else {
        frame.ParseFromArray(payload.data(), size);
        note(frame.source_time_ns(), now_ns);
      }
    }
  }
  bool echo_, bundle_;
  void *context_, *socket_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

// Measures one round against the process at these addresses.
void Measure(const Options& options, const Variant& variant, const std::string& udp,
             const std::string& publish, pid_t pid, const std::string& control, Result& result) {
  std::vector<std::unique_ptr<Listener>> listeners;
  for (int i = 0; i < options.subscribers; ++i) {
    listeners.push_back(
        std::make_unique<Listener>(publish, options.performers, variant.echo, variant.bundle));
  }
  std::vector<support::Rig> rigs;
  std::vector<std::unique_ptr<support::UdpLink>> links;
  for (int i = 0; i < options.performers; ++i) {
    rigs.emplace_back("p" + std::to_string(i), 7 + i);
    links.push_back(std::make_unique<support::UdpLink>(udp));
    links.back()->Send(rigs.back().Body());
  }
  support::Sleep(0.3);
  // Performers are not synchronized: they send at no more than kInstants instants, evenly spread
  // over the period.
  constexpr int kInstants = 16;
  const int group = (options.performers + kInstants - 1) / kInstants;
  const double period_ns = 1e9 / options.rate_hz;
  const auto total = static_cast<int>((options.seconds + 1) * options.rate_hz);
  const auto measured_from = static_cast<int>(options.rate_hz);  // the first second is the warm-up
  const std::int64_t start_ns = Now_ns() + 1'000'000;
  double cpu_us = 0;
  std::uint64_t sent = 0;
  for (int k = 0; k < total; ++k) {
    for (int i = 0; i < options.performers; ++i) {
      const int first = i / group * group;
      const double due_ns = (k + static_cast<double>(first) / options.performers) * period_ns;
      const Clock::time_point due{
          std::chrono::nanoseconds(start_ns + static_cast<std::int64_t>(due_ns))};
      if (i == first) std::this_thread::sleep_until(due);
      if (k == measured_from && i == 0) {
        cpu_us = PipelineCpu_us(pid);
        for (auto& listener : listeners) listener->from_ns = Now_ns();
      }
      rigs[i].time_ns = static_cast<std::uint64_t>(Now_ns());
      links[i]->Send(rigs[i].Frame());
      if (k >= measured_from) ++sent;
    }
  }
  for (auto& listener : listeners) listener->to_ns = Now_ns();
  cpu_us = PipelineCpu_us(pid) - cpu_us;
  result.rss_mb = Rss_mb(pid);
  if (!control.empty()) {  // of the last second under load
    const auto status = support::ControlClient(control).Status();
    for (const auto& stage : status.stats().stages()) {
      result.stages_us[stage.name()] += stage.mean_us();
    }
    ++result.stage_rounds;
  }
  support::Sleep(0.3);
  result.sent += sent;
  result.frames += sent;
  result.cpu_us += cpu_us;
  for (auto& listener : listeners) {
    listener->Stop();
    result.lost += sent - listener->latency_us.size();
    result.latency_us.insert(result.latency_us.end(), listener->latency_us.begin(),
                             listener->latency_us.end());
  }
}

void Round(const Options& options, const Variant& variant, Result& result) {
  if (variant.echo) {
    EchoChild echo(variant.wait, options.daemon_cpu, options.priority);
    Measure(options, variant, echo.udp, echo.publish, echo.pid(), "", result);
    return;
  }
  support::Daemon daemon(
      {"realtime.wait=" + variant.wait,
       std::string("realtime.prewarm=") + (variant.prewarm ? "true" : "false"),
       "realtime.cpu=" + std::to_string(options.daemon_cpu),
       "realtime.priority=" + std::to_string(options.priority), "performers.max_performers=1024",
       "style.initial=" + options.style, "model.precision=" + options.precision},
      "", {}, options.weights);
  std::unique_ptr<Examples> examples;
  if (variant.like) {
    examples = std::make_unique<Examples>(daemon.control, options.like, result.like_ms);
  }
  Measure(options, variant, daemon.udp, daemon.publish, daemon.child->pid(), daemon.control,
          result);
}

double Quantile(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return 0;
  return sorted[std::min(sorted.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(sorted.size())))];
}

int Main(const Options& options) {
  std::vector<Variant> variants{{"echo, block", "block", true, false},
                                {"styled, block", "block", false, false},
                                {"styled, block, prewarm", "block", false, true},
                                {"styled, block, bundle", "block", false, false, false, true},
                                {"echo, hybrid", "hybrid", true, false},
                                {"styled, hybrid", "hybrid", false, false},
                                {"styled, hybrid, prewarm", "hybrid", false, true},
                                {"echo, busy", "busy", true, false},
                                {"styled, busy", "busy", false, false}};
  if (!options.like.empty()) {
    variants.insert(variants.begin() + 2, {"styled, block, like", "block", false, false, true});
  }
  if (!options.only.empty()) {
    std::erase_if(variants, [&options](const Variant& variant) {
      return std::ranges::find(options.only, variant.name) == options.only.end();
    });
  }
  std::map<std::string, Result> results;
  for (int round = 0; round < options.rounds; ++round) {
    for (const Variant& variant : variants) {
      Round(options, variant, results[variant.name]);
      std::cerr << '.' << std::flush;
    }
  }
  std::cerr << '\n';
  std::printf("%d performers, %d subscribers, %.0f Hz, %d rounds of %.0f s\n", options.performers,
              options.subscribers, options.rate_hz, options.rounds, options.seconds);
  std::printf("%-24s %9s %9s %9s %9s %9s %7s %10s %12s %12s\n", "", "p50 us", "p99 us", "p99.9 us",
              "max us", "> 8.33 ms", "lost", "cpu us/fr", "p50 / echo", "p99 / echo");
  nlohmann::json json;
  double echo_p50_us = 0, echo_p99_us = 0;
  for (const Variant& variant : variants) {
    Result& result = results[variant.name];
    std::sort(result.latency_us.begin(), result.latency_us.end());
    const double p50_us = Quantile(result.latency_us, 0.5);
    const double p99_us = Quantile(result.latency_us, 0.99);
    if (variant.echo || echo_p50_us == 0) {
      echo_p50_us = p50_us;
      echo_p99_us = p99_us;
    }
    const double cpu_us =
        result.cpu_us / static_cast<double>(std::max<std::uint64_t>(1, result.frames));
    const auto over =
        result.latency_us.end() -
        std::upper_bound(result.latency_us.begin(), result.latency_us.end(), kPeriod_us);
    std::printf("%-24s %9.1f %9.1f %9.1f %9.1f %9td %7llu %10.1f %12.2f %12.2f\n",
                variant.name.c_str(), p50_us, p99_us, Quantile(result.latency_us, 0.999),
                Quantile(result.latency_us, 1), over, static_cast<unsigned long long>(result.lost),
                cpu_us, p50_us / echo_p50_us, p99_us / echo_p99_us);
    auto& row = json[variant.name];
    row = {{"p50_us", p50_us},
           {"p99_us", p99_us},
           {"p999_us", Quantile(result.latency_us, 0.999)},
           {"max_us", Quantile(result.latency_us, 1)},
           {"over_period", over},
           {"sent", result.sent},
           {"lost", result.lost},
           {"cpu_us_per_frame", cpu_us}};
    for (const double share :
         {0.0, 0.01, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95, 0.99, 0.995, 0.999, 0.9999, 1.0}) {
      row["quantiles_us"].push_back({share, Quantile(result.latency_us, share)});
    }
    row["rss_mb"] = result.rss_mb;
    for (const auto& [stage, sum_us] : result.stages_us) {
      row["stages_us"][stage] = sum_us / result.stage_rounds;
    }
  }
  for (const Variant& variant : variants) {
    std::vector<double>& took_ms = results[variant.name].like_ms;
    if (took_ms.empty()) continue;
    std::sort(took_ms.begin(), took_ms.end());
    std::printf("%-24s %zu styles of examples, ms from request to reply: p50 %.1f, p99 %.1f\n",
                variant.name.c_str(), took_ms.size(), Quantile(took_ms, 0.5),
                Quantile(took_ms, 0.99));
    json[variant.name]["like_ms"] = {{"p50", Quantile(took_ms, 0.5)},
                                     {"p99", Quantile(took_ms, 0.99)}};
  }
  for (const Variant& variant : variants) {
    const Result& result = results[variant.name];
    if (result.stage_rounds == 0) continue;
    std::printf("%-24s us of the pipeline per frame:", variant.name.c_str());
    for (const char* const stage : {"take", "style", "serialize", "send"}) {
      const auto found = result.stages_us.find(stage);
      if (found != result.stages_us.end()) {
        std::printf(" %s %.1f", stage, found->second / result.stage_rounds);
      }
    }
    std::printf("\n");
  }
  if (!options.json.empty()) std::ofstream(options.json) << json.dump(2) << "\n";
  return 0;
}

}  // namespace
}  // namespace styled::bench

int main(int argc, char** argv) {
  styled::bench::Options options;
  CLI::App app{"Latency of the daemon against an echo loop, from send to receive"};
  app.option_defaults()->always_capture_default();
  app.add_option("--performers", options.performers, "at once, out of step");
  app.add_option("--subscribers", options.subscribers, "each of all performers");
  app.add_option("--rounds", options.rounds, "of all variants in turn");
  app.add_option("--seconds", options.seconds, "of each round");
  app.add_option("--rate", options.rate_hz, "of each performer, Hz");
  app.add_option("--cpu", options.daemon_cpu, "core of the loop; -1 = any");
  app.add_option("--priority", options.priority, "SCHED_FIFO of the daemon's loop; 0 = normal");
  app.add_option("--only", options.only, "variants by name, e.g. \"styled, block\"; empty: all");
  app.add_option("--weights", options.weights, "weights file");
  app.add_option("--precision", options.precision, "int8 or float32, of the weights");
  app.add_option("--style", options.style, "in force");
  app.add_option("--like", options.like,
                 "a BVH clip: one more variant, in which a style is made of it every second")
      ->check(CLI::ExistingFile);
  app.add_option("--json", options.json, "write the figures there, too");
  CLI11_PARSE(app, argc, argv);
  return styled::bench::Main(options);
}
