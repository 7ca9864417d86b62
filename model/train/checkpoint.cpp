#include "model/train/checkpoint.h"

#include <cstring>
#include <sstream>

#include "model/net/weights_file.h"

namespace styled::train {
namespace {

using torch::Tensor;

Tensor FromString(const std::string& text) {
  Tensor bytes = torch::empty({static_cast<int64_t>(text.size())}, torch::kUInt8);
  std::memcpy(bytes.data_ptr(), text.data(), text.size());
  return bytes;
}

}  // namespace

std::string FamilyOf(const Checkpoint& checkpoint) {
  const auto found = checkpoint.strings.find("family");
  return found == checkpoint.strings.end() ? net::kStyleErd : found->second;
}

std::string Reason(const std::exception& error) {
  const auto* torch_error = dynamic_cast<const c10::Error*>(&error);
  const std::string text =
      torch_error != nullptr ? torch_error->what_without_backtrace() : error.what();
  return text.substr(0, text.find('\n'));
}

std::filesystem::path PartialFile(std::filesystem::path file) { return file += ".partial"; }

Status ReplaceByPartial(const std::filesystem::path& file) {
  std::error_code error;
  std::filesystem::rename(PartialFile(file), file, error);
  return error ? Status::Error(file.string() + ": " + error.message()) : Status::Ok();
}

void SaveAdam(const std::string& name, const Adam& adam, Checkpoint& checkpoint) {
  checkpoint.tensors[name + ".first"] = adam.first;
  checkpoint.tensors[name + ".second"] = adam.second;
  checkpoint.tensors[name + ".steps"] = torch::tensor({adam.steps}, torch::kInt64);
}

void RestoreAdam(const std::string& name, const Checkpoint& checkpoint, Adam& adam) {
  adam.first.copy_(checkpoint.tensors.at(name + ".first"));
  adam.second.copy_(checkpoint.tensors.at(name + ".second"));
  adam.steps = checkpoint.tensors.at(name + ".steps").item<int64_t>();
}

Status WriteCheckpoint(const Checkpoint& checkpoint, const std::filesystem::path& file) {
  try {
    torch::serialize::OutputArchive archive;
    std::string names;
    for (const auto& [name, tensor] : checkpoint.tensors) {
      archive.write("t." + name, tensor.detach().cpu());
      names += "t." + name + "\n";
    }
    for (const auto& [name, text] : checkpoint.strings) {
      archive.write("s." + name, FromString(text));
      names += "s." + name + "\n";
    }
    archive.write("names", FromString(names));
    archive.save_to(PartialFile(file).string());
  } catch (const std::exception& error) {
    return Status::Error(file.string() + ": " + Reason(error));
  }
  return ReplaceByPartial(file);
}

Status ReadCheckpoint(const std::filesystem::path& file, Checkpoint& checkpoint) {
  try {
    torch::serialize::InputArchive archive;
    archive.load_from(file.string(), torch::kCPU);
    const auto text = [&archive](const std::string& key) {
      Tensor bytes;
      archive.read(key, bytes);
      return std::string(static_cast<const char*>(bytes.data_ptr()), bytes.numel());
    };
    std::istringstream names(text("names"));
    for (std::string name; std::getline(names, name);) {
      if (name.starts_with("t.")) {
        archive.read(name, checkpoint.tensors[name.substr(2)]);
      } else {
        checkpoint.strings[name.substr(2)] = text(name);
      }
    }
  } catch (const std::exception& error) {
    return Status::Error(file.string() + ": not a checkpoint of styletrain: " + Reason(error));
  }
  return Status::Ok();
}

}  // namespace styled::train
