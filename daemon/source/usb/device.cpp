#include "daemon/source/usb/device.h"

namespace styled::source::usb {
namespace {

using runtime::Counter;

constexpr int kInterruptTransfers = 8, kBulkTransfers = 4;
constexpr int kReportSize = 64;
constexpr int kBulkSize = static_cast<int>(Reports::kMaxSize);
constexpr int kGivesUp = 16;

}  // namespace

Device::Device(OwnedHandle handle, const Interface& interface, std::uint32_t number,
               Reports& reports, runtime::Counters& counters)
    : handle_(std::move(handle)),
      interface_(interface),
      number_(number),
      reports_(reports),
      counters_(counters) {
  const int count = interface.bulk ? kBulkTransfers : kInterruptTransfers;
  const int size = interface.bulk ? kBulkSize : kReportSize;
  buffer_.resize(static_cast<std::size_t>(count) * static_cast<std::size_t>(size));
  for (int i = 0; i < count; ++i) {
    transfers_.emplace_back(libusb_alloc_transfer(0));
    auto* at =
        reinterpret_cast<unsigned char*>(buffer_.data()) + static_cast<std::ptrdiff_t>(i) * size;
    const auto fill = interface.bulk ? libusb_fill_bulk_transfer : libusb_fill_interrupt_transfer;
    fill(transfers_.back().get(), handle_.get(), interface.endpoint, at, size, &Device::OnTransfer,
         this, 0);
  }
}

Device::~Device() { libusb_release_interface(handle_.get(), interface_.number); }

Result<std::unique_ptr<Device>> Device::Start(OwnedHandle handle, const Interface& interface,
                                              std::uint32_t number, Reports& reports,
                                              runtime::Counters& counters) {
  std::unique_ptr<Device> device(
      new Device(std::move(handle), interface, number, reports, counters));
  Status status = device->Claim();
  if (!status.ok()) return status;
  device->SubmitAll();
  return device;
}

Status Device::Claim() {
  libusb_set_auto_detach_kernel_driver(handle_.get(), 1);
  const int result = libusb_claim_interface(handle_.get(), interface_.number);
  if (result == LIBUSB_SUCCESS) return Status::Ok();
  return Status::Error(
      "interface " + std::to_string(interface_.number) + " cannot be claimed: " +
      (result == LIBUSB_ERROR_BUSY ? "another program uses it" : libusb_strerror(result)));
}

void Device::OnTransfer(libusb_transfer* transfer) {
  static_cast<Device*>(transfer->user_data)->Complete(*transfer);
}

void Device::Complete(libusb_transfer& transfer) {
  --under_way_;
  // A cancelled or failed transfer may have delivered bytes; an empty one ended a burst.
  if (transfer.actual_length > 0) {
    reports_.PushData(
        number_, std::as_bytes(
                     std::span(transfer.buffer, static_cast<std::size_t>(transfer.actual_length))));
  }
  switch (transfer.status) {
    case LIBUSB_TRANSFER_COMPLETED:
      failures_ = 0;
      break;
    case LIBUSB_TRANSFER_CANCELLED:
      break;
    case LIBUSB_TRANSFER_NO_DEVICE:
      Stop("unplugged");
      break;
    case LIBUSB_TRANSFER_STALL:
      Fail(State::kStalled);
      break;
    default:  // corrupted on the bus, or larger than the buffer
      Fail(State::kStreaming);
      break;
  }
  if (state_ == State::kStreaming) Submit(transfer);
}

void Device::Fail(State next) {
  if (state_ != State::kStreaming) return;  // the other transfers report the same stall
  counters_.Add(Counter::kUsbTransfersFailed);
  if (++failures_ >= kGivesUp) return Stop("its transfers fail");
  if (next == State::kStalled) {
    state_ = next;
    CancelAll();
  }
}

bool Device::Submit(libusb_transfer& transfer) {
  const int result = libusb_submit_transfer(&transfer);
  if (result == LIBUSB_SUCCESS) {
    ++under_way_;
    return true;
  }
  if (result != LIBUSB_ERROR_NO_DEVICE) counters_.Add(Counter::kUsbTransfersFailed);
  Stop(result == LIBUSB_ERROR_NO_DEVICE ? "unplugged" : "its transfers fail");
  return false;
}

void Device::SubmitAll() {
  for (const auto& transfer : transfers_) {
    if (!Submit(*transfer)) return;
  }
}

void Device::CancelAll() {
  for (const auto& transfer : transfers_) libusb_cancel_transfer(transfer.get());
}

void Device::Stop(const char* reason) {
  if (state_ == State::kEnding) return;
  state_ = State::kEnding;
  reason_ = reason;
  CancelAll();
}

void Device::Service() {
  if (state_ != State::kStalled || under_way_ > 0) return;
  const int result = libusb_clear_halt(handle_.get(), interface_.endpoint);
  if (result == LIBUSB_ERROR_NO_DEVICE) return Stop("unplugged");
  state_ = State::kStreaming;
  SubmitAll();
}

}  // namespace styled::source::usb
