#include "tests/support/daemon.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/rig.h"
#include "tests/unit/net/erd/random_weights.h"

namespace styled::support {

void WriteRandomWeights(const std::string& file, int styles, unsigned seed) {
  WriteWeights(file, erd::RandomWeights(styles, seed));
}

void WriteWeights(const std::string& file, const erd::WeightsFile& weights) {
  const auto bytes = weights.Bytes();
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
}

std::string Binary() { return STYLED_BINARY; }

Daemon::Daemon(std::vector<std::string> settings, const std::string& extra,
               const std::map<std::string, std::string>& environment, const std::string& weights)
    : settings_(std::move(settings)), environment_(environment) {
  if (weights.empty()) {
    WriteRandomWeights(folder / "weights.safetensors");
  } else {
    std::filesystem::copy_file(weights, folder / "weights.safetensors");
  }
  Configure(extra);
  Start();
}

void Daemon::Configure(const std::string& extra) {
  WriteText(folder / "styled.toml",
            "[[source]]\nname = \"rig\"\ntype = \"udp\"\nlisten = \"127.0.0.1:0\"\n"
            "[[source]]\nname = \"tcp\"\ntype = \"tcp\"\nlisten = \"127.0.0.1:0\"\n"
            "[publish]\naddress = \"tcp://127.0.0.1:0\"\nhigh_water_mark = 2000\n"
            "[control]\naddress = \"tcp://127.0.0.1:0\"\n" +
                extra);
}

void Daemon::Start() {
  const std::string ready = folder / "ready.json";
  std::filesystem::remove(ready);
  std::vector<std::string> arguments{Binary(),
                                     "--config",
                                     folder / "styled.toml",
                                     "--weights",
                                     folder / "weights.safetensors",
                                     "--ready-file",
                                     ready};
  std::vector<std::string> settings{"realtime.lock_memory=false", "performers.backlog_ms=10000",
                                    "performers.stale_ms=3000",   "performers.takeover_ms=1000",
                                    "realtime.relieve=false",     "model.gaits=none"};
  settings.insert(settings.end(), settings_.begin(), settings_.end());
  for (const auto& setting : settings) {
    arguments.emplace_back("--set");
    arguments.push_back(setting);
  }
  child = std::make_unique<Child>(arguments, folder / "stderr.txt", environment_);
  for (int i = 0; i < 2000 && !std::filesystem::exists(ready) && child->Running(); ++i) Sleep(0.01);
  ASSERT_TRUE(std::filesystem::exists(ready)) << Log();
  const auto json = nlohmann::json::parse(ReadText(ready));
  udp = json["sources"][0]["listen"];
  tcp = json["sources"][1]["listen"];
  listens.clear();
  for (const auto& source : json["sources"]) listens.push_back(source["listen"]);
  publish = json["publish"];
  control = json["control"];
  osc = json["osc"];
  server_key = json.value("server_key", "");
}

int Daemon::Stop() {
  child->Signal(SIGTERM);
  return child->Wait(5).value_or(-1);
}

}  // namespace styled::support
