#include "proto/styled/explain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>

#include "model/base/text.h"
#include "proto/styled/v1/frame.pb.h"

namespace styled {
namespace {

constexpr std::array kReasons{
    RefusalReason{"pipeline.before_body", "the skeleton of its session has not arrived",
                  "let the rig send the skeleton, at its start and once a second: restart the "
                  "sender"},
    RefusalReason{"pipeline.uncalibrated", "the rig's rest pose is unknown",
                  "let the performer stand in T-pose: stylectl calibrate % --pose t"},
    RefusalReason{"pipeline.wrong_size", "the skeleton has another number of joints",
                  "let the rig send its skeleton again after a change: restart the sender"},
    RefusalReason{"pipeline.wrong_body", "another skeleton is named than the one that was sent",
                  "restart the sender"},
    RefusalReason{"pipeline.duplicate", "the sequence number was received before",
                  "check whether a device on the way sends everything twice, or whether two "
                  "senders use one session"},
    RefusalReason{"pipeline.reordered", "a newer frame has arrived already",
                  "send by cable or by TCP, where the network reorders; a sender that restarts "
                  "must take a new session id"},
    RefusalReason{"pipeline.far_ahead", "the sequence number is far ahead of the last one",
                  "restart the sender; if two programs send under one session id, stop one of "
                  "them"},
    RefusalReason{"pipeline.old_time", "the sender's time is not after that of the frame before",
                  "restart the sender; if it plays a recording, let it run"},
    RefusalReason{"pipeline.second_sender", "another sender has this performer's name already",
                  "stop one of the two, or give it another performer's name"},
    RefusalReason{"pipeline.bodies_refused", "the skeleton is refused, and the log says why",
                  "correct the rig's skeleton, or name its joints by `joints` of the [[source]]"},
    RefusalReason{"pipeline.performers_refused", "max_performers are here already",
                  "raise it in [performers]"},
    RefusalReason{"pipeline.backlog_dropped", "frames had piled up, and a newer one was waiting",
                  "look at the network and at the load of the machine: stylectl doctor"},
};

constexpr std::array<std::string_view, 5> kLimbs{"left arm", "right arm", "trunk", "left leg",
                                                 "right leg"};
// Below this, a limb is reported: one that shows half of the style looks as captured.
constexpr float kHeldBack = 0.5F;

std::string WhyRefused(const v1::FrameFate& fate) {
  const RefusalReason* const reason = FindRefusalReason(fate.reason());
  if (reason != nullptr) {
    return std::string(reason->why) + ": " + CureText(*reason, fate.performer());
  }
  return fate.reason().empty() ? "the leader of the pair refused it"
                               : "counted as " + fate.reason();
}

std::string WhichPose(v1::Failure failure) {
  switch (failure) {
    case v1::FAILURE_PREDICTION:
      return "the network's prediction";
    case v1::FAILURE_CANONICAL:
      return "the styled pose";
    case v1::FAILURE_RIG:
      return "the styled pose on the rig's skeleton";
    case v1::FAILURE_AVATAR:
      return "the styled pose on an avatar";
    default:
      return "a pose";
  }
}

std::string Centimetres(float metres) {
  return std::to_string(static_cast<int>(std::lround(100 * metres))) + " cm";
}

class Sentences {
 public:
  void Add(std::string sentence) {
    if (sentence.empty()) return;
    text_ += text_.empty() ? "" : " ";
    text_ += std::move(sentence);
    text_ += ".";
  }
  std::string Pop() { return std::move(text_); }

 private:
  std::string text_;
};

// Limbs that show little of the style.
std::string HeldBackLimbs(const v1::FrameFate& fate) {
  std::string limbs;
  const int count = std::min(fate.limb_weights_size(), static_cast<int>(kLimbs.size()));
  for (int i = 0; i < count; ++i) {
    if (fate.limb_weights(i) >= kHeldBack) continue;
    limbs += (limbs.empty() ? "" : ", ") + std::string(kLimbs[static_cast<std::size_t>(i)]) + " (" +
             std::to_string(static_cast<int>(std::lround(100 * fate.limb_weights(i)))) + " %";
    if (i < fate.limb_errors_m_size()) limbs += ", off by " + Centimetres(fate.limb_errors_m(i));
    limbs += ")";
  }
  if (limbs.empty()) return "";
  return "Little of the style shows on: " + limbs +
         ". The training data of the style has no motion like this one, so these limbs keep the "
         "performer's own motion";
}

std::string RestartText(v1::Restart restart) {
  switch (restart) {
    case v1::RESTART_SESSION:
      return "A session begins with it, so the style restarts: the sender restarted, or another "
             "sender took over";
    case v1::RESTART_RECOUNT:
      return "The sender counts from another number, so the style restarts";
    case v1::RESTART_CLOCK_JUMP:
      return "The sender's clock jumped, so the style restarts: let the sender use one clock";
    default:
      return "";
  }
}

void AddFlags(const v1::FrameFate& fate, Sentences& to) {
  const auto has = [flags = fate.flags()](v1::Flag flag) {
    return (flags & static_cast<std::uint32_t>(flag)) != 0;
  };
  if (has(v1::FLAG_STALE)) {
    to.Add("The performer fell silent, and this is a repetition of the last pose");
  }
  if (has(v1::FLAG_FAILED)) {
    to.Add("It is the performer's own motion because " + WhichPose(fate.failure()) +
           " was not sound: record it ([record]) and report it, or try other weights");
  } else if (fate.relieved()) {
    to.Add(
        "The style is left out because the machine cannot keep up: fewer performers, or a "
        "faster machine (stylectl doctor)");
  } else if (has(v1::FLAG_BYPASS) && !has(v1::FLAG_STALE)) {
    to.Add("No style is set: stylectl set " + fate.performer() + " --style NAME");
  }
  if (fate.failure() == v1::FAILURE_AVATAR && !has(v1::FLAG_FAILED)) {
    to.Add(
        "An avatar ([[output]]) shows the performer's own motion because the styled pose on it "
        "was not sound: check the avatar's skeleton");
  }
  if (has(v1::FLAG_OUT_OF_DOMAIN)) {
    to.Add(
        "The pose is far from all training data, so most of the style is withheld: "
        "calibrate the rig if the performer just walks");
  }
  if (has(v1::FLAG_HELD)) {
    to.Add(std::to_string(fate.held_joints()) +
           (fate.held_joints() == 1 ? " joint was" : " joints were") + " not tracked" +
           (fate.held_joint().empty() ? std::string() : " (" + fate.held_joint() + " first)") +
           ": they keep their last rotation; look for occluded markers or a lost tracker");
  }
  if (has(v1::FLAG_CONCEALED)) {
    to.Add("Frames before it were lost, and the gap was bridged: look at the network");
  }
  if (has(v1::FLAG_BACKWARDS)) {
    to.Add(
        "The performer walks against where the toes point: left and right are exchanged, or the "
        "axes are mirrored");
  }
  if (has(v1::FLAG_FADING)) to.Add("A change of style is under way");
}

}  // namespace

const RefusalReason* FindRefusalReason(std::string_view counter) {
  const auto* const found = std::ranges::find(kReasons, counter, &RefusalReason::counter);
  return found == kReasons.end() ? nullptr : found;
}

std::string CureText(const RefusalReason& reason, std::string_view performer) {
  std::string text(reason.cure);
  if (const std::size_t at = text.find('%'); at != std::string::npos) {
    text.replace(at, 1, performer);
  }
  return text;
}

std::string CauseText(const v1::FrameFate& fate) {
  Sentences text;
  const std::string what = fate.is_body() ? "The skeleton" : "The frame";
  if (!fate.reason().empty() && fate.fate() == v1::FATE_PASSED_OVER) {
    text.Add(what + " was skipped because " + WhyRefused(fate));
  } else if (fate.fate() == v1::FATE_REFUSED && !(fate.is_body() && fate.reason().empty())) {
    text.Add(what + " was refused because " + WhyRefused(fate));
  }
  text.Add(RestartText(fate.restart()));
  if (fate.lost() > 0) {
    text.Add(std::to_string(fate.lost()) + " before it " + (fate.lost() == 1 ? "was" : "were") +
             " lost on the way: look at the network (stylectl doctor)");
  }
  if (fate.fate() != v1::FATE_STYLED) return text.Pop();
  if ((fate.flags() & v1::FLAG_LATE) != 0) {
    text.Add(
        "It arrived behind the performer's own schedule: the sender or the network paused "
        "(stylectl doctor)");
  }
  if (fate.period_ms() > 0 && fate.latency_ms() > fate.period_ms()) {
    text.Add("It was sent more than a period after it arrived: this machine was busy");
  }
  AddFlags(fate, text);
  text.Add(HeldBackLimbs(fate));
  return text.Pop();
}

std::string ExplainText(const v1::FrameFate& fate) {
  const std::string number = fate.sequence() != 0
                                 ? "frame " + std::to_string(fate.sequence())
                                 : (fate.is_body() ? "skeleton" : "frame") + std::string(" ") +
                                       std::to_string(fate.source_sequence()) + " of the sender";
  std::string text = number + ": ";
  switch (fate.fate()) {
    case v1::FATE_STYLED:
      text += "published";
      if (fate.latency_ms() > 0)
        text += " " + NumberText(fate.latency_ms(), 2) + " ms after it arrived";
      if ((fate.flags() & v1::FLAG_LATE) != 0) {
        text += ", " + NumberText(fate.lateness_ms(), 1) + " ms behind schedule";
      }
      break;
    case v1::FATE_PASSED_OVER:
      text += "skipped, " + NumberText(fate.lateness_ms(), 1) + " ms behind schedule";
      break;
    default:
      text += fate.is_body() && fate.reason().empty() ? "accepted" : "refused";
  }
  const std::string cause = CauseText(fate);
  return text + (cause.empty() ? "." : ". " + cause);
}

std::string ExplainLines(std::span<const v1::FrameFate> fates) {
  std::string text;
  for (std::size_t i = 0; i < fates.size();) {
    const std::string cause = CauseText(fates[i]);
    std::size_t end = i + 1;
    while (end < fates.size() && fates[end].fate() == fates[i].fate() &&
           fates[end].is_body() == fates[i].is_body() && CauseText(fates[end]) == cause) {
      ++end;
    }
    const v1::FrameFate &first = fates[i], &last = fates[end - 1];
    const std::size_t count = end - i;
    i = end;
    if (count == 1) {
      text += ExplainText(first) + "\n";
      continue;
    }
    const bool published = first.sequence() != 0;
    text += (first.is_body() ? "skeletons " : "frames ") +
            std::to_string(published ? first.sequence() : first.source_sequence()) + " to " +
            std::to_string(published ? last.sequence() : last.source_sequence()) +
            (published ? "" : " of the sender") + " (" + std::to_string(count) +
            "): " + (published ? "published" : "not published") + ". " + cause;
    if (text.ends_with(' ')) text.pop_back();
    text += "\n";
  }
  return text;
}

}  // namespace styled
