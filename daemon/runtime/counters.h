#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <string_view>

#include "model/base/realtime.h"
#include "proto/rigs/native/datagram.h"

namespace styled::runtime {

// Everything that the daemon counts, each with a name of the form `folder.event` (Name()). Hostile
// or late input is never logged where it happens. It is counted here, and once a second the
// supervisor logs which of the trouble counters grew.
enum class Counter : std::uint8_t {
  kSourceReceived,  // datagrams and records that arrived
  // The next nine are in the order of native::DecodeResult, from kTooShort on; CounterOf() relies
  // on it.
  kSourceTooShort,
  kSourceTooLong,
  kSourceBadMagic,
  kSourceBadVersion,
  kSourceLengthMismatch,
  kSourceBadChecksum,
  kSourceBadReserved,
  kSourceBadKind,
  kSourceNoSession,
  kSourceMalformed,       // not the message that its header announces, or not the rig's protocol
  kSourceIncomplete,      // frames, or samples split over several datagrams, of which a part is
                          // missing
  kSourceIgnored,         // messages of a rig that carry no pose
  kSourceBeforeRestPose,  // frames of a rig that has not sent name and rest pose yet
  kSourceBadName,         // performer's name is not [A-Za-z0-9_-]{1,32}
  kSourceKernelDropped,   // datagrams that the kernel dropped because the socket's buffer was full
  kSourceRateLimited,     // datagrams of a sender beyond sender_limit_hz; not in kSourceReceived
  kSourceTakeovers,       // refused: handshakes for a live tracker from another address
  kSourceTableFull,       // handshakes of trackers for which there is no room
  kSourceTcpAccepted,
  kSourceTcpRefused,   // refused because max_connections connections were open, all of them sending
  kSourceTcpGaveWay,   // silent connections closed to make room for a new one
  kSourceTcpSilent,    // closed because no complete record came in time
  kSourceTcpBroken,    // closed because the stream lost its framing; the reason has its own counter
  kSourceTcpCutShort,  // closed by the sender in the middle of a record
  kUsbOpened,          // devices opened, counted again after each replug
  kUsbLostDevices,     // devices unplugged or given up
  kUsbTransfersFailed,
  kUsbBadReports,   // not a report of the rig, or not a record of the native protocol
  kUsbRingFull,     // transfers dropped because the pipeline was behind
  kPipelineFrames,  // accepted
  kPipelineBodies,  // accepted, repetitions included
  kPipelineBodyChanges,
  kPipelineBodiesRefused,
  kPipelineBeforeBody,    // frames whose session has sent no body
  kPipelineUncalibrated,  // frames of a performer whose rig's rest pose is unknown
  kPipelineWrongSize,     // frames whose joint count differs from the body's
  kPipelineWrongBody,     // frames that name another body than the last one sent
  kPipelineDuplicate,     // sequence number seen before
  kPipelineReordered,     // sequence number older than the last and not seen before
  kPipelineFarAhead,      // sequence number implausibly far ahead of the last
  kPipelineOldTime,       // source time not after the last frame's
  kPipelineLost,  // sequence numbers skipped, including those that arrive later as reordered
  kPipelineSecondSender,
  kPipelineSessions,    // started
  kPipelineClockJumps,  // sessions started because the sender's clock jumped
  kPipelineRecounts,    // sessions started because a sender continued from another sequence number
  kPipelineLate,        // frames published with FLAG_LATE
  kPipelineBacklogDropped,  // frames skipped because a newer one was waiting
  kPipelineStale,           // performers that fell silent: a frame published with FLAG_STALE
  kPipelineIdle,        // frames of bodies that moved by themselves while their rigs were silent
  kPipelinePerformers,  // the current number
  kPipelinePerformersRefused,
  kPipelineForgotten,
  kPipelineNamesReplaced,  // stored settings dropped because a new performer arrived at a full
                           // table
  kPipelineNamesExpired,   // stored settings dropped because their performer never arrived
  kPipelineCommands,
  kPipelineCues,
  kPipelineCuesRefused,
  kPipelinePrewarmed,         // frames whose data was brought into the caches beforehand
  kPipelineOverBudget,        // cycles longer than a frame's period at 120 Hz
  kPipelineOverBudgetFrames,  // frames that left later than a period of their rig after they
                              // arrived
  kPipelineOverloadBypassed,  // frames sent without style because the machine cannot keep up
  kPipelineWallClockSteps,    // the wall clock was set
  kPipelineLongestCycleUs,    // the longest cycle of the last second, in microseconds
  kPipelineEventsDropped,     // log messages dropped because their ring was full
  kPipelineEventsHeldBack,    // log messages held back by the limit per kind and performer
  kPipelineBackwards,         // frames published with FLAG_BACKWARDS
  kPipelinePropsLeftOut,      // published frames with this flag; the same holds for the counters up
                              // to kStylistFailed
  kStylistConcealed,  // published frames with this flag; so are the others up to kStylistFailed
  kStylistHeld,
  kStylistOutOfDomain,
  kStylistFading,
  kStylistNewSession,
  kStylistFailed,
  kStylistFailedPrediction,  // of these, by the pose that was not sound (v1::Failure)
  kStylistFailedCanonical,
  kStylistFailedRig,
  kStylistFailedAvatar,
  kStylistSteps,  // steps of the network
  kPublishMessages,
  kPublishFailed,
  kPublishBodies,
  kPublishSubscriptions,         // the current number of distinct subscriptions
  kPublishSubscriptionsRefused,  // over max_subscriptions, or of a topic that is never published
  kPublishBadMessages,           // messages from subscribers that are not subscriptions
  kPublishCanaryReceived,        // messages received by the daemon's own subscriber
  kPublishCanaryMissed,          // messages missed by it
  kPublishStalled,     // subscribers found to have stopped reading, again after each recovery
  kPublishStalledNow,  // the current number of stalled subscribers
  kControlRequests,
  kControlOsc,
  kControlRefused,  // requests answered with any code but CODE_OK; includes the next three
  kControlMalformed,
  kControlTooLarge,
  kControlBusy,
  kSecurityClients,           // the current number of allowed keys
  kSecurityAdmitted,          // handshakes with an allowed key
  kSecurityRefused,           // handshakes with a key that is unknown or has the wrong role
  kSecurityHandshakesFailed,  // handshakes that failed before the key check: no CURVE, or another
                              // server's key
  kSecurityCut,               // connections cut because the client was revoked
  kConfigReloads,
  kConfigReloadsRefused,
  kStateWrites,
  kStateWritesFailed,
  kRecordOn,        // 1: arriving data is being recorded
  kRecordWritten,   // records in the file
  kRecordLost,      // records that were not written because the disk was slow, full or gone
  kRecordFailures,  // distinct reasons for lost records, each logged once
  kCount
};

// The counter of a decoder's refusal. `result` must not be kOk.
constexpr Counter CounterOf(native::DecodeResult result) {
  return static_cast<Counter>(static_cast<int>(Counter::kSourceTooShort) +
                              static_cast<int>(result) -
                              static_cast<int>(native::DecodeResult::kTooShort));
}

// The counter's name, e.g. "source.bad_checksum".
std::string_view Name(Counter counter) noexcept;
// Whether growth of this counter is logged as a warning.
bool IsTrouble(Counter counter) noexcept;

// The table of counters: always on and lock-free. Any thread may call any function.
class Counters {
 public:
  STYLED_REALTIME void Add(Counter counter, std::uint64_t amount = 1) noexcept {
    At(counter).fetch_add(amount, std::memory_order_relaxed);
  }
  // The same, and marks source `source` as a cause. All sources from 63 on share one mark.
  STYLED_REALTIME void AddOf(int source, Counter counter, std::uint64_t amount = 1) noexcept {
    Add(counter, amount);
    sources_[static_cast<std::size_t>(counter)].fetch_or(
        std::uint64_t{1} << static_cast<unsigned>(std::min(source, 63)), std::memory_order_relaxed);
  }
  // The sources that AddOf() marked since the last call: bit i is source i. Clears the marks.
  std::uint64_t ClearSources(Counter counter) noexcept {
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
