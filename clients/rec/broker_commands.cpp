// `stylerec jetstream` and `stylerec fetch`: recordings of a NATS broker, made by stylenats'
// frames.
#include <algorithm>
#include <map>
#include <set>

#include "clients/nats/demand.h"
#include "clients/nats/recordings.h"
#include "clients/nats/subject.h"
#include "clients/rec/commands.h"
#include "clients/rec/time_text.h"
#include "model/base/terminal_text.h"
#include "proto/recording/writer.h"

namespace styled::rec {
namespace {

using std::string;
using stylenats::Recorded;
using stylenats::Recordings;

constexpr std::string_view kBodyTail = ".body";
// A bridge repeats a body once a second (stylenats::BodyBeat); it may have arrived late.
constexpr std::int64_t kBodiesBefore_ns = 2'000'000'000;
constexpr double kGigabyte = 1e9, kHourIn_ns = 3600e9;

Result<std::unique_ptr<Recordings>> OpenBroker(const Arguments& a) {
  stylenats::LinkOptions link = a.broker;
  link.name = "stylerec";
  const Status status = stylenats::Complete(a.login, link);
  if (!status.ok()) return status;
  return Recordings::Open(link, a.domain);
}

// "body/PERFORMER/" or "styled/PERFORMER/STREAM/"; "" for subjects that stylenats does not publish.
string TopicOfRecorded(const string& subject) {
  if (!subject.ends_with(kBodyTail)) return stylenats::TopicOf(subject);
  const string topic = stylenats::TopicOf(subject.substr(0, subject.size() - kBodyTail.size()));
  const std::size_t slash = topic.find('/');
  if (slash == string::npos) return "";
  return "body" + topic.substr(slash, topic.find('/', slash + 1) + 1 - slash);
}

// Writes the recorded messages of a span of time, and counts them.
class Fetching {
 public:
  Fetching(const Arguments& a, std::int64_t from_ns, std::int64_t to_ns)
      : a_(a), from_ns_(from_ns), to_ns_(to_ns) {}

  // False: the span is over.
  Result<bool> Add(const Recorded& recorded);
  Status Finish() { return writer_ ? writer_->Flush() : Status::Ok(); }
  void Report(std::ostream& out) const {
    out << "stylerec: " << a_.file << ": frames=" << frames_ << " bodies=" << bodies_
        << " missed=" << missed_ << " restarts=" << restarts_ << " odd=" << odd_ << " from "
        << TimeText(first_ns_) << " to " << TimeText(last_ns_)
        << " bytes=" << writer_->counts().bytes << "\n";
  }
  std::uint64_t frames() const { return frames_; }

 private:
  struct Place {
    std::uint64_t epoch = 0, sequence = 0;
  };
  void CountGap(const Recorded& recorded);
  Status Write(const Recorded& recorded, const string& topic);

  const Arguments& a_;
  const std::int64_t from_ns_, to_ns_;
  std::unique_ptr<recording::FileWriter> writer_;
  recording::Record record_;
  std::map<string, Recorded> before_;  // by subject, the newest bodies before the span
  std::map<string, Place> places_;     // by subject
  std::int64_t first_ns_ = 0, last_ns_ = 0;
  std::uint64_t frames_ = 0, bodies_ = 0, missed_ = 0, restarts_ = 0, odd_ = 0;
};

void Fetching::CountGap(const Recorded& recorded) {
  const auto [known, first] = places_.try_emplace(recorded.subject);
  Place& place = known->second;
  if (!first && place.epoch != recorded.epoch) {
    ++restarts_;
  } else if (!first && recorded.sequence > place.sequence) {
    missed_ += recorded.sequence - place.sequence - 1;
  }
  place = {recorded.epoch, recorded.sequence};
}

Status Fetching::Write(const Recorded& recorded, const string& topic) {
  record_.set_time_ns(recorded.time_ns);
  record_.mutable_published()->set_topic(topic);
  record_.mutable_published()->set_payload(recorded.payload);
  ++(recorded.subject.ends_with(kBodyTail) ? bodies_ : frames_);
  return writer_->Add(record_, recorded.time_ns);
}

Result<bool> Fetching::Add(const Recorded& recorded) {
  if (recorded.time_ns > to_ns_) return false;
  const string topic = TopicOfRecorded(recorded.subject);
  const bool body = topic.starts_with("body/");
  if (recorded.time_ns < from_ns_) {
    if (body) before_[recorded.subject] = recorded;
    return true;
  }
  if (topic.empty()) {
    ++odd_;
    return true;
  }
  if (!writer_) {
    // The file exists from the first message on. Its times are the broker's.
    recording::FileHeader header = recording::BeginningNow("stylerec", STYLED_VERSION);
    header.set_created_unix_ns(recorded.time_ns);
    header.set_created_time_ns(recorded.time_ns);
    header.set_description(a_.description);
    auto writer = recording::FileWriter::Create(a_.file, header);
    if (!writer.ok()) return writer.status();
    writer_ = std::move(writer.value());
    first_ns_ = recorded.time_ns;
    for (auto& [subject, earlier] : before_) {
      earlier.time_ns = recorded.time_ns;
      const Status status = Write(earlier, TopicOfRecorded(subject));
      if (!status.ok()) return status;
    }
  }
  last_ns_ = recorded.time_ns;
  if (!body) CountGap(recorded);
  const Status status = Write(recorded, topic);
  if (!status.ok()) return status;
  return true;
}

string Decoded(std::string_view token) {
  return stylenats::Unescape(token).value_or(string(token));
}

// The streams that are recorded, "rig, canonical".
string StreamsOf(const std::vector<string>& subjects) {
  string list;
  for (const string& subject : subjects) {
    if (subject.ends_with(kBodyTail)) continue;
    list += (list.empty() ? "" : ", ") + Decoded(subject.substr(subject.rfind('.') + 1));
  }
  return list;
}

// "hall rig.anna: canonical 1200, rig 1200": a line for each performer in `messages`.
std::map<string, string> LinesOf(const std::map<string, std::uint64_t>& recorded) {
  std::map<string, string> lines;
  for (const auto& [subject, messages] : recorded) {
    if (subject.ends_with(kBodyTail)) continue;
    const std::size_t site = subject.find('.') + 1, performer = subject.find('.', site) + 1,
                      stream = subject.find('.', performer) + 1;
    if (site == 0 || performer == 0 || stream == 0) continue;
    string& line = lines[Decoded(subject.substr(site, performer - 1 - site)) + " " +
                         Decoded(subject.substr(performer, stream - 1 - performer))];
    line += (line.empty() ? "" : ", ") + Decoded(subject.substr(stream)) + " " +
            std::to_string(messages);
  }
  return lines;
}

// The reason why a site has no messages in a span of time.
Status NothingFound(const Arguments& a, Recordings& recordings, std::int64_t from_ns,
                    std::int64_t to_ns) {
  string text = "nothing of site " + a.site + (a.performer.empty() ? "" : ", " + a.performer) +
                " from " + TimeText(from_ns) + " to " + TimeText(to_ns) + "; ";
  const auto state = recordings.Look();
  if (!state.ok()) return Status::Error(text + state.status().message());
  if (state.value().messages == 0) return Status::Error(text + "the recording is empty");
  std::set<string> there;
  for (const auto& [name, line] : LinesOf(state.value().recorded)) there.insert(name);
  text += "the recording goes from " + TimeText(state.value().first_ns) + " to " +
          TimeText(state.value().last_ns) + " and has";
  for (const string& name : there) text += (name == *there.begin() ? " " : ", ") + name;
  return Status::Error(text);
}

Status CreateRecording(const Arguments& a, Recordings& recordings, std::ostream& out) {
  const auto made = recordings.Create({a.streams, a.max_gb, a.max_hours});
  if (!made.ok()) return made.status();
  out << "stylerec: " << (made.value() ? "recording" : "limits changed") << ": at most " << a.max_gb
      << " GB and " << a.max_hours << " h\n";
  return Status::Ok();
}

Status ShowRecording(Recordings& recordings, std::ostream& out) {
  const auto looked = recordings.Look();
  if (!looked.ok()) return looked.status();
  const stylenats::RecordingState& state = looked.value();
  out << "streams: " << ForTerminal(StreamsOf(state.subjects)) << "\n"
      << "size: " << static_cast<double>(state.bytes) / kGigabyte << " of "
      << static_cast<double>(state.max_bytes) / kGigabyte << " GB, " << state.messages
      << " messages\n"
      << "age: at most " << static_cast<double>(state.max_age_ns) / kHourIn_ns << " h";
  if (state.messages > 0) {
    out << "; from " << TimeText(state.first_ns) << " to " << TimeText(state.last_ns);
  }
  out << "\n";
  for (const auto& [name, line] : LinesOf(state.recorded))
    out << ForTerminal(name + ": " + line) << "\n";
  return Status::Ok();
}

}  // namespace

Status RunJetStream(const Arguments& a, const Dependencies& to) {
  const auto recordings = OpenBroker(a);
  if (!recordings.ok()) return recordings.status();
  if (a.action == "create") return CreateRecording(a, *recordings.value(), to.out);
  if (a.action == "status") return ShowRecording(*recordings.value(), to.out);
  const Status status = recordings.value()->Delete();
  if (status.ok()) to.out << "stylerec: the recording is deleted\n";
  return status;
}

Status RunFetch(const Arguments& a, const Dependencies& to) {
  const std::int64_t now_ns = recording::BeginningNow("", "").created_unix_ns();
  std::int64_t from_ns = kBodiesBefore_ns, to_ns = now_ns;
  for (const auto& [text, time_ns] : {std::pair{&a.from_time, &from_ns}, {&a.to_time, &to_ns}}) {
    if (text->empty()) continue;
    const auto time = ParseTime(*text, now_ns);
    if (!time.ok()) return time.status();
    *time_ns = time.value();
  }
  const auto recordings = OpenBroker(a);
  if (!recordings.ok()) return recordings.status();
  auto reader = recordings.value()->Read(a.site, a.performer, from_ns - kBodiesBefore_ns);
  if (!reader.ok()) return reader.status();
  Fetching fetching(a, from_ns, to_ns);
  Status status = Status::Ok();
  Recorded recorded;
  while (!to.stop) {
    auto more = reader.value()->Next(recorded);
    if (more.ok() && more.value()) more = fetching.Add(recorded);
    if (!more.ok()) status = more.status();
    if (!more.ok() || !more.value()) break;
  }
  const Status flushed = fetching.Finish();
  if (status.ok()) status = flushed;
  if (fetching.frames() > 0) {
    fetching.Report(to.out);
  } else if (status.ok()) {
    status = NothingFound(a, *recordings.value(), from_ns, to_ns);
  }
  return status;
}

}  // namespace styled::rec
