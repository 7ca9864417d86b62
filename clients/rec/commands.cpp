#include "clients/rec/commands.h"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "clients/rec/info.h"
#include "clients/rec/receive.h"
#include "clients/rec/take.h"
#include "clients/rec/tap.h"
#include "proto/recording/writer.h"

namespace styled::rec {
namespace {

using std::string;

Result<std::unique_ptr<recording::FileWriter>> Create(const Arguments& a) {
  recording::FileHeader header = recording::BeginningNow("stylerec", STYLED_VERSION);
  header.set_description(a.description);
  if (!a.config.empty()) {
    std::ifstream in(a.config, std::ios::binary);
    if (!in) return Status::Error(a.config + ": cannot be read");
    header.set_config(string(std::istreambuf_iterator<char>(in), {}));
  }
  if (!a.weights.empty()) {
    const auto hash = recording::HashOfFile(a.weights);
    if (!hash.ok()) return hash.status();
    header.set_weights(std::filesystem::path(a.weights).filename().string());
    header.set_weights_hash(hash.value());
  }
  return recording::FileWriter::Create(a.file, header);
}

Result<std::vector<Port>> MakePorts(const Arguments& a) {
  std::vector<Port> ports;
  for (std::size_t i = 0; i < a.listen.size(); ++i) {
    Port port;
    port.listen = a.listen[i];
    port.name = CutName(port.listen);
    if (port.name.empty()) port.name = i == 0 ? "rig" : "rig" + std::to_string(i + 1);
    port.type = a.type;
    if (!port.listen.starts_with("udp://")) {
      return Status::Error("--listen " + a.listen[i] + ": expected [NAME=]udp://HOST:PORT");
    }
    port.listen = port.listen.substr(6);
    if (i < a.forward.size()) port.forward = a.forward[i];
    if (port.forward.starts_with("udp://")) port.forward = port.forward.substr(6);
    ports.push_back(std::move(port));
  }
  return ports;
}

Status WriteFiles(const Arguments& a, const Take& take) {
  for (const auto& [format, file] : a.exports) {
    const auto motion = ToMotion(take, a.rate_hz, *format);
    if (!motion.ok()) return motion.status();
    const Status status = format->write(motion.value(), file);
    if (!status.ok()) return status;
  }
  return Status::Ok();
}

}  // namespace

string CutName(string& address) {
  const std::size_t sign = address.find('=');
  if (sign == string::npos) return "";
  string name = address.substr(0, sign);
  address = address.substr(sign + 1);
  return name;
}

Result<std::unique_ptr<recording::Reader>> OpenRecording(const Arguments& a) {
  return recording::Reader::Open(a.file, {.salvage = a.salvage});
}

void ReportDamage(const recording::Reader& reader, const Dependencies& to) {
  const string damage = recording::DamageText(reader.counts());
  if (!damage.empty()) to.err << "stylerec: " << reader.name() << ": " << damage << "\n";
}

Status RunRecord(const Arguments& a, const Dependencies& to) {
  auto curve = client::ReadKeys(a.keys);
  if (!curve.ok()) return curve.status();
  TapOptions options{a.from, a.topics, a.performer, a.seconds, std::move(curve.value())};
  if (!a.performer.empty()) options.topics = TopicsOf(a.performer);
  auto tap = Tap::Connect(options);
  if (!tap.ok()) return tap.status();
  auto writer = Create(a);
  if (!writer.ok()) return writer.status();
  Status status = tap.value()->Run(*writer.value(), to.stop, to.err);
  const auto& counts = tap.value()->counts();
  const auto& written = writer.value()->counts();
  to.out << "stylerec: " << a.file << ": messages=" << counts.messages
         << " missed=" << counts.missed << " odd=" << counts.odd
         << " lost=" << written.lost + written.too_large << " bytes=" << written.bytes << "\n";
  if (counts.messages == 0) {
    to.err << "stylerec: " << a.file << " is empty: nothing arrived\n";
  } else if (counts.messages == counts.statistics && !a.performer.empty()) {
    to.err << "stylerec: " << a.file << " has nothing of " << a.performer << ", only statistics; "
           << tap.value()->ListPerformers() << "\n";
  } else if (counts.messages == counts.statistics && a.topics.empty()) {
    to.err << "stylerec: " << a.file << " has no motion, only statistics\n";
  }
  return status;
}

Status RunReceive(const Arguments& a, const Dependencies& to) {
  auto ports = MakePorts(a);
  if (!ports.ok()) return ports.status();
  auto receiver = Receiver::Open(std::move(ports.value()));
  if (!receiver.ok()) return receiver.status();
  auto writer = Create(a);
  if (!writer.ok()) return writer.status();
  for (const string& endpoint : receiver.value()->endpoints()) {
    to.err << "stylerec: listening on " << endpoint << "\n" << std::flush;
  }
  Status status = receiver.value()->Run(*writer.value(), a.seconds, to.stop);
  const auto& counts = receiver.value()->counts();
  const auto& written = writer.value()->counts();
  to.out << "stylerec: " << a.file << ": datagrams=" << counts.datagrams
         << " received_bytes=" << counts.bytes << " forwarded=" << counts.forwarded
         << " answered=" << counts.answered << " dropped=" << counts.dropped
         << " lost=" << written.lost + written.too_large << " bytes=" << written.bytes << "\n";
  return status;
}

Status RunInfo(const Arguments& a, const Dependencies& to) {
  const auto reader = OpenRecording(a);
  if (!reader.ok()) return reader.status();
  Info(*reader.value(), a.json, to.out);
  return Status::Ok();
}

Status RunExport(const Arguments& a, const Dependencies& to) {
  const auto reader = OpenRecording(a);
  if (!reader.ok()) return reader.status();
  const What what = a.what == "rig"         ? What::kRig
                    : a.what == "canonical" ? What::kCanonical
                    : a.what == "source"    ? What::kSource
                                            : What::kAvatar;
  for (const auto& [format, file] : a.exports) {
    std::error_code error;
    if (a.overwrite || !std::filesystem::is_regular_file(file, error)) continue;
    return Status::Error(file + ": exists already; expected a new file, or --overwrite");
  }
  const auto take = ReadTake(*reader.value(), a.performer, what, a.what);
  if (!take.ok()) return take.status();
  const Take& it = take.value();
  Status status = WriteFiles(a, it);
  if (!status.ok()) return status;
  to.out << "stylerec: " << a.performer << " " << a.what << ": frames=" << it.frames.size()
         << " seconds=" << it.times_s.back() << " joints=" << it.skeleton.joint_count()
         << " metres_per_unit=" << it.metres_per_unit << (it.unit_known ? "" : " (by hips height)")
         << " restarts=" << it.restarts << " on_other_bodies=" << it.on_other_bodies
         << " unusable=" << it.unusable;
  if (it.pauses > 0) {
    to.out << " pauses_shortened=" << it.pauses << " left_out_s=" << it.left_out_s;
  }
  to.out << "\n";
  ReportDamage(*reader.value(), to);
  return Status::Ok();
}

}  // namespace styled::rec
