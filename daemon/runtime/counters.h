#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <string_view>

#include "model/base/realtime.h"
#include "proto/rigs/native/datagram.h"

namespace styled::runtime {

// Everything that the daemon counts, by name `folder.event` (Name()). Hostile or late input is
// never logged where it happens: it is counted here, and the supervisor says once a second which
// counts of trouble grew.
enum class Counter : std::uint8_t {
  kSourceReceived,  // datagrams and records
  // In the order of native::DecodeResult from kTooShort on.
  kSourceTooShort,
  kSourceTooLong,
  kSourceBadMagic,
  kSourceBadVersion,
  kSourceLengthMismatch,
  kSourceBadChecksum,
  kSourceBadReserved,
  kSourceBadKind,
  kSourceNoSession,
  kSourceMalformed,      // not the message that the header says, or not the rig's protocol
  kSourceIncomplete,     // frames, or samples in several datagrams, of which a part is missing
  kSourceIgnored,        // messages of a rig that say nothing of a pose
  kSourceBadName,        // performer's name is not [A-Za-z0-9_-]{1,32}
  kSourceKernelDropped,  // the socket's buffer was full
  kSourceRateLimited,    // one sender's, beyond sender_limit_hz; not in kSourceReceived
  kSourceTakeovers,      // refused: greetings for a live tracker, from another address
  kSourceTableFull,      // greetings of trackers for which there is no room
  kSourceTcpAccepted,
  kSourceTcpRefused,   // more connections than max_connections, all of them sending
  kSourceTcpGaveWay,   // silent ones, closed for a new one where all were taken
  kSourceTcpSilent,    // closed because no whole record came in time
  kSourceTcpBroken,    // stream out of step: closed; the reason is counted beside
  kSourceTcpCutShort,  // closed by the sender within a record
  kUsbOpened,          // devices, again after each replug
  kUsbLostDevices,     // unplugged or given up
  kUsbTransfersFailed,
  kUsbBadReports,   // no report of the rig, or no record of ours
  kUsbRingFull,     // transfers dropped because the pipeline was behind
  kPipelineFrames,  // accepted
  kPipelineBodies,  // accepted, repetitions included
  kPipelineBodyChanges,
  kPipelineBodiesRefused,
  kPipelineBeforeBody,    // frames whose session has sent no body
  kPipelineUncalibrated,  // frames of a performer whose rig's rest pose nobody knows
  kPipelineWrongSize,     // frames whose joint count is not the body's
  kPipelineWrongBody,     // frames that name another body than the last
  kPipelineDuplicate,     // sequence seen before
  kPipelineReordered,     // sequence older than the last, not seen before
  kPipelineFarAhead,      // sequence implausibly far ahead of the last
  kPipelineOldTime,       // source time not after the last frame's
  kPipelineLost,          // sequence numbers skipped (those that come later as reordered included)
  kPipelineSecondSender,
  kPipelineSessions,        // started
  kPipelineClockJumps,      // sessions started because the sender's clock jumped
  kPipelineRecounts,        // sessions started because a sender went on from another sequence
  kPipelineLate,            // frames published with FLAG_LATE
  kPipelineBacklogDropped,  // frames passed over because a newer one was waiting
  kPipelineStale,           // frames published with FLAG_STALE
  kPipelinePerformers,      // now
  kPipelinePerformersRefused,
  kPipelineForgotten,
  kPipelineNamesReplaced,  // settings that gave way to a performer who came to a full table
  kPipelineNamesExpired,   // settings of performers who were named and never came
  kPipelineCommands,
  kPipelineCues,
  kPipelinePrewarmed,       // frames that were prepared for
  kPipelineOverBudget,      // cycles longer than a frame's period at 120 Hz
  kPipelineLongestCycleUs,  // of the last second
  kPipelineEventsDropped,   // messages to the log that found its ring full
  kPipelineEventsHeldBack,  // messages to the log beyond the limit of their kind and performer
  kPipelineBackwards,       // frames published with FLAG_BACKWARDS
  kStylistConcealed,        // frames with the flag, as the next five
  kStylistHeld,
  kStylistOutOfDomain,
  kStylistFading,
  kStylistNewSession,
  kStylistFailed,
  kStylistSteps,  // of the network
  kPublishMessages,
  kPublishFailed,
  kPublishBodies,
  kPublishSubscriptions,         // now, distinct
  kPublishSubscriptionsRefused,  // over max_subscriptions, or matching nothing we publish
  kPublishBadMessages,           // from subscribers, and no subscription
  kControlRequests,
  kControlOsc,
  kControlRefused,  // answered with any code but CODE_OK; the next three are among them
  kControlMalformed,
  kControlTooLarge,
  kControlBusy,
  kSecurityClients,           // let in, now
  kSecurityAdmitted,          // handshakes of clients that are
  kSecurityRefused,           // handshakes with a key that opens nothing here
  kSecurityHandshakesFailed,  // without a key of ours: no CURVE, or another server's
  kSecurityCut,               // connections of clients who were revoked
  kConfigReloads,
  kConfigReloadsRefused,
  kStateWrites,
  kStateWritesFailed,
  kRecordOn,        // 1: what arrives is being recorded
  kRecordWritten,   // records in the file
  kRecordLost,      // records that are not: the disk was slow, full or gone
  kRecordFailures,  // reasons for that, each said in the log once
  kCount
};

// The counter of a decoder's refusal (not kOk).
constexpr Counter CounterOf(native::DecodeResult result) {
  return static_cast<Counter>(static_cast<int>(Counter::kSourceTooShort) +
                              static_cast<int>(result) -
                              static_cast<int>(native::DecodeResult::kTooShort));
}

// "source.bad_checksum".
std::string_view Name(Counter counter) noexcept;
// Whether growth of it deserves a line in the log.
bool IsTrouble(Counter counter) noexcept;

// The table: always on, lock-free, any thread.
class Counters {
 public:
  STYLED_REALTIME void Add(Counter counter, std::uint64_t amount = 1) noexcept {
    At(counter).fetch_add(amount, std::memory_order_relaxed);
  }
  // The same, of source `source` (those from 63 on are one).
  STYLED_REALTIME void AddOf(int source, Counter counter, std::uint64_t amount = 1) noexcept {
    Add(counter, amount);
    sources_[static_cast<std::size_t>(counter)].fetch_or(
        std::uint64_t{1} << static_cast<unsigned>(std::min(source, 63)), std::memory_order_relaxed);
  }
  // Of which sources AddOf() counted since the last call: bit i is source i.
  std::uint64_t TakeSources(Counter counter) noexcept {
    return sources_[static_cast<std::size_t>(counter)].exchange(0, std::memory_order_relaxed);
  }
  STYLED_REALTIME void Set(Counter counter, std::uint64_t value) noexcept {
    At(counter).store(value, std::memory_order_relaxed);
  }
  std::uint64_t Get(Counter counter) const noexcept {
    return values_[static_cast<std::size_t>(counter)].load(std::memory_order_relaxed);
  }

 private:
  std::atomic<std::uint64_t>& At(Counter counter) noexcept {
    return values_[static_cast<std::size_t>(counter)];
  }
  std::array<std::atomic<std::uint64_t>, static_cast<std::size_t>(Counter::kCount)> values_{};
  std::array<std::atomic<std::uint64_t>, static_cast<std::size_t>(Counter::kCount)> sources_{};
};

}  // namespace styled::runtime
