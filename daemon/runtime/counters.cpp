#include "daemon/runtime/counters.h"

namespace styled::runtime {
namespace {

struct Row {
  Counter counter;
  std::string_view name;
  bool trouble = false;
};

constexpr std::array<Row, static_cast<std::size_t>(Counter::kCount)> kRows{{
    {Counter::kSourceReceived, "source.received"},
    {Counter::kSourceTooShort, "source.too_short", true},
    {Counter::kSourceTooLong, "source.too_long", true},
    {Counter::kSourceBadMagic, "source.bad_magic", true},
    {Counter::kSourceBadVersion, "source.bad_version", true},
    {Counter::kSourceLengthMismatch, "source.length_mismatch", true},
    {Counter::kSourceBadChecksum, "source.bad_checksum", true},
    {Counter::kSourceBadReserved, "source.bad_reserved", true},
    {Counter::kSourceBadKind, "source.bad_kind", true},
    {Counter::kSourceNoSession, "source.no_session", true},
    {Counter::kSourceMalformed, "source.malformed", true},
    {Counter::kSourceIncomplete, "source.incomplete", true},
    {Counter::kSourceIgnored, "source.ignored"},
    {Counter::kSourceBeforeRestPose, "source.before_rest_pose", true},
    {Counter::kSourceBadName, "source.bad_name", true},
    {Counter::kSourceKernelDropped, "source.kernel_dropped", true},
    {Counter::kSourceRateLimited, "source.rate_limited", true},
    {Counter::kSourceTakeovers, "source.takeovers_refused", true},
    {Counter::kSourceTableFull, "source.table_full", true},
    {Counter::kSourceTcpAccepted, "source.tcp_accepted"},
    {Counter::kSourceTcpRefused, "source.tcp_refused", true},
    {Counter::kSourceTcpGaveWay, "source.tcp_gave_way", true},
    {Counter::kSourceTcpSilent, "source.tcp_silent", true},
    {Counter::kSourceTcpBroken, "source.tcp_broken", true},
    {Counter::kSourceTcpCutShort, "source.tcp_cut_short", true},
    {Counter::kUsbOpened, "usb.opened"},
    {Counter::kUsbLostDevices, "usb.lost_devices", true},
    {Counter::kUsbTransfersFailed, "usb.transfers_failed", true},
    {Counter::kUsbBadReports, "usb.bad_reports", true},
    {Counter::kUsbRingFull, "usb.ring_full", true},
    {Counter::kPipelineFrames, "pipeline.frames"},
    {Counter::kPipelineBodies, "pipeline.bodies"},
    {Counter::kPipelineBodyChanges, "pipeline.body_changes"},
    {Counter::kPipelineBodiesRefused, "pipeline.bodies_refused", true},
    {Counter::kPipelineBeforeBody, "pipeline.before_body", true},
    {Counter::kPipelineUncalibrated, "pipeline.uncalibrated", true},
    {Counter::kPipelineWrongSize, "pipeline.wrong_size", true},
    {Counter::kPipelineWrongBody, "pipeline.wrong_body", true},
    {Counter::kPipelineDuplicate, "pipeline.duplicate", true},
    {Counter::kPipelineReordered, "pipeline.reordered", true},
    {Counter::kPipelineFarAhead, "pipeline.far_ahead", true},
    {Counter::kPipelineOldTime, "pipeline.old_time", true},
    {Counter::kPipelineLost, "pipeline.lost", true},
    {Counter::kPipelineSecondSender, "pipeline.second_sender", true},
    {Counter::kPipelineSessions, "pipeline.sessions"},
    {Counter::kPipelineClockJumps, "pipeline.clock_jumps", true},
    {Counter::kPipelineRecounts, "pipeline.recounts", true},
    {Counter::kPipelineLate, "pipeline.late"},
    {Counter::kPipelineBacklogDropped, "pipeline.backlog_dropped", true},
    {Counter::kPipelineStale, "pipeline.stale"},
    {Counter::kPipelineIdle, "pipeline.idle"},
    {Counter::kPipelinePerformers, "pipeline.performers"},
    {Counter::kPipelinePerformersRefused, "pipeline.performers_refused", true},
    {Counter::kPipelineForgotten, "pipeline.forgotten"},
    {Counter::kPipelineNamesReplaced, "pipeline.names_replaced", true},
    {Counter::kPipelineNamesExpired, "pipeline.names_expired"},
    {Counter::kPipelineCommands, "pipeline.commands"},
    {Counter::kPipelineCues, "pipeline.cues"},
    {Counter::kPipelineCuesRefused, "pipeline.cues_refused"},
    {Counter::kPipelinePrewarmed, "pipeline.prewarmed"},
    {Counter::kPipelineOverBudget, "pipeline.over_budget_cycles"},
    {Counter::kPipelineOverBudgetFrames, "pipeline.over_budget_frames", true},
    {Counter::kPipelineOverloadBypassed, "pipeline.overload_bypassed_frames", true},
    {Counter::kPipelineWallClockSteps, "pipeline.wall_clock_steps"},
    {Counter::kPipelineLongestCycleUs, "pipeline.longest_cycle_us"},
    {Counter::kPipelineEventsDropped, "pipeline.events_dropped", true},
    {Counter::kPipelineEventsHeldBack, "pipeline.events_held_back"},
    {Counter::kPipelineBackwards, "pipeline.backwards"},
    {Counter::kPipelinePropsLeftOut, "pipeline.props_left_out", true},
    {Counter::kStylistConcealed, "stylist.concealed"},
    {Counter::kStylistHeld, "stylist.held"},
    {Counter::kStylistOutOfDomain, "stylist.out_of_domain"},
    {Counter::kStylistFading, "stylist.fading"},
    {Counter::kStylistNewSession, "stylist.new_session"},
    {Counter::kStylistFailed, "stylist.failed", true},
    {Counter::kStylistFailedPrediction, "stylist.failed_prediction", true},
    {Counter::kStylistFailedCanonical, "stylist.failed_canonical", true},
    {Counter::kStylistFailedRig, "stylist.failed_rig", true},
    {Counter::kStylistFailedAvatar, "stylist.failed_avatar", true},
    {Counter::kStylistSteps, "stylist.steps"},
    {Counter::kPublishMessages, "publish.messages"},
    {Counter::kPublishFailed, "publish.failed", true},
    {Counter::kPublishBodies, "publish.bodies"},
    {Counter::kPublishSubscriptions, "publish.subscriptions"},
    {Counter::kPublishSubscriptionsRefused, "publish.subscriptions_refused", true},
    {Counter::kPublishBadMessages, "publish.bad_messages", true},
    {Counter::kPublishCanaryReceived, "publish.canary_received"},
    {Counter::kPublishCanaryMissed, "publish.canary_missed", true},
    {Counter::kPublishStalled, "publish.subscribers_stalled", true},
    {Counter::kPublishStalledNow, "publish.stalled_now"},
    {Counter::kControlRequests, "control.requests"},
    {Counter::kControlOsc, "control.osc"},
    {Counter::kControlRefused, "control.refused", true},
    {Counter::kControlMalformed, "control.malformed", true},
    {Counter::kControlTooLarge, "control.too_large", true},
    {Counter::kControlBusy, "control.busy", true},
    {Counter::kSecurityClients, "security.clients"},
    {Counter::kSecurityAdmitted, "security.admitted"},
    {Counter::kSecurityRefused, "security.refused"},
    {Counter::kSecurityHandshakesFailed, "security.handshakes_failed", true},
    {Counter::kSecurityCut, "security.cut"},
    {Counter::kConfigReloads, "config.reloads"},
    {Counter::kConfigReloadsRefused, "config.reloads_refused"},
    {Counter::kStateWrites, "state.writes"},
    {Counter::kStateWritesFailed, "state.writes_failed", true},
    {Counter::kRecordOn, "record.on"},
    {Counter::kRecordWritten, "record.written"},
    {Counter::kRecordLost, "record.lost", true},
    {Counter::kRecordFailures, "record.failures"},
}};

constexpr bool InOrder() {
  for (std::size_t i = 0; i < kRows.size(); ++i) {
    if (static_cast<std::size_t>(kRows[i].counter) != i || kRows[i].name.empty()) return false;
  }
  return true;
}
static_assert(InOrder(), "one row per counter, in the order of the enumeration");
static_assert(CounterOf(native::DecodeResult::kTooShort) == Counter::kSourceTooShort);
static_assert(CounterOf(native::DecodeResult::kNoSession) == Counter::kSourceNoSession);

}  // namespace

std::string_view Name(Counter counter) noexcept {
  return kRows[static_cast<std::size_t>(counter)].name;
}

bool IsTrouble(Counter counter) noexcept {
  return kRows[static_cast<std::size_t>(counter)].trouble;
}

}  // namespace styled::runtime
