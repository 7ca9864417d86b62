#include "daemon/source/usb/usb.h"

#include <algorithm>
#include <string>

#include "daemon/source/outbox.h"
#include "daemon/source/usb/records.h"
#include "daemon/source/usb/reports.h"
#include "daemon/source/usb/usb_thread.h"

namespace styled::source {
namespace {

using usb::Records;
using usb::Reports;
using usb::UsbThread;

std::string Text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string Describe(const config::Source& config) {
  std::string text = config.usb_id.empty() ? "any receiver" : config.usb_id;
  if (!config.serial.empty()) text += " serial " + config.serial;
  return text;
}

// The common part: the thread that fills `reports_`, and the descriptor that the pipeline polls.
class Usb : public Transport {
 public:
  Usb(const config::Source& config, int source, runtime::Clock& clock, runtime::Counters& counters)
      : source_(source),
        clock_(clock),
        counters_(counters),
        reports_(clock, counters),
        endpoint_(Describe(config)) {}

  Status Start(usb::Wanted wanted) {
    auto thread = UsbThread::Start(std::move(wanted), reports_, clock_, counters_);
    if (!thread.ok()) return thread.status();
    thread_ = std::move(thread.value());
    return Status::Ok();
  }
  int fd() const override { return reports_.fd(); }
  const std::string& endpoint() const override { return endpoint_; }

 protected:
  STYLED_REALTIME void Announce(const Reports::Report& report, Receiver& receiver) const noexcept {
    receiver.OnArrival({source_, report.arrival_ns, report.bytes, nullptr, 0, report.device});
  }

  int source_;
  runtime::Clock& clock_;
  runtime::Counters& counters_;
  Reports reports_;

 private:
  std::string endpoint_;
  std::unique_ptr<UsbThread>
      thread_;  // declared after reports_: ends before the ring that it fills
};

// Native records.
class NativeUsb final : public Usb {
 public:
  NativeUsb(const config::Source& config, int source, runtime::Clock& clock,
            runtime::Counters& counters)
      : Usb(config, source, clock, counters), records_(source, counters) {}

  int DoWork(Receiver& receiver) override {
    reports_.Clear();
    Reports::Report report;
    int work = 0;
    for (; work < static_cast<int>(kBatch) && reports_.Pop(report); ++work) {
      if (report.is_note) {
        receiver.OnNote(source_, Text(report.bytes));
        continue;
      }
      Announce(report, receiver);
      records_.Decode(report, receiver);
    }
    return work;
  }

  std::uint64_t received() const override { return records_.received(); }

 private:
  Records records_;
};

// A rig's reports, through its translator.
class TranslatedUsb final : public Usb {
 public:
  TranslatedUsb(const config::Source& config, int source, runtime::Clock& clock,
                runtime::Counters& counters, std::unique_ptr<Translator> translator)
      : Usb(config, source, clock, counters),
        translator_(std::move(translator)),
        outbox_(source, counters) {}

  int DoWork(Receiver& receiver) override {
    reports_.Clear();
    std::int64_t until_ns = clock_.Now_ns();
    int work = 0;
    outbox_.Open(receiver, -1);
    Reports::Report report;
    while (work < static_cast<int>(kBatch) && reports_.Pop(report)) {
      ++work;
      if (report.is_note) {
        outbox_.Note([&report] { return Text(report.bytes); });
        continue;
      }
      Announce(report, receiver);
      ++received_;
      Peer peer;
      peer.id = report.device;
      translator_->Handle(report.bytes, peer, report.arrival_ns, outbox_);
    }
    // A waiting report may follow a silence and must not be mistaken for it.
    if (work == static_cast<int>(kBatch)) until_ns = std::min(until_ns, report.arrival_ns);
    if (until_ns >= translator_->NextDeadline_ns()) ++work;
    translator_->Tick(until_ns, outbox_);
    outbox_.Close();
    return work;
  }

  std::uint64_t received() const override { return received_; }
  std::int64_t NextDeadline_ns() const override { return translator_->NextDeadline_ns(); }
  bool has_sensors() const override { return translator_->has_sensors(); }
  Status Calibrate(Calibration what, std::int64_t now_ns) override {
    return translator_->Calibrate(what, now_ns);
  }

 private:
  std::unique_ptr<Translator> translator_;
  Outbox outbox_;
  std::uint64_t received_ = 0;
};

}  // namespace

Result<std::unique_ptr<Transport>> MakeUsb(const config::Source& config, int source,
                                           runtime::Clock& clock, runtime::Counters& counters,
                                           std::unique_ptr<Translator> translator) {
  usb::Wanted wanted;
  wanted.serial = config.serial;
  if (!config.usb_id.empty()) {
    const auto id = config::ParseUsbId(config.usb_id);
    if (!id.ok()) return id.status();
    wanted.id = id.value();
  }
  std::unique_ptr<Usb> made;
  if (translator == nullptr) {
    wanted.protocol = usb::Protocol::kNative;
    made = std::make_unique<NativeUsb>(config, source, clock, counters);
  } else {
    made = std::make_unique<TranslatedUsb>(config, source, clock, counters, std::move(translator));
  }
  const Status status = made->Start(std::move(wanted));
  if (!status.ok()) return status;
  return std::unique_ptr<Transport>(std::move(made));
}

}  // namespace styled::source
