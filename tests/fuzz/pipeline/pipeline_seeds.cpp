// Writes seeds of pipeline_fuzz: scripts that use every action.
#include <random>

#include "tests/fuzz/pipeline/script.h"
#include "tests/fuzz/write_seeds.h"

int main(int argc, char** argv) {
  using styled::fuzz::Action;
  constexpr int kScripts = 12, kActions = 60, kSenders = 3;
  std::mt19937 random(1);
  std::vector<std::vector<std::byte>> seeds(kScripts);
  for (auto& script : seeds) {
    for (int i = 0; i < kActions; ++i) {
      // First a body of each sender, then every action, with frames most often.
      auto action = static_cast<Action>(random() % static_cast<unsigned>(Action::kCount));
      if (random() % 3 == 0) action = Action::kFrames;
      if (i < kSenders) action = Action::kBody;
      script.push_back(static_cast<std::byte>(action));
      script.push_back(static_cast<std::byte>(i < kSenders ? i : static_cast<int>(random())));
      if (i < kSenders) {
        script.push_back(std::byte{0});
        continue;
      }
      for (unsigned k = random() % 10; k > 0; --k) {
        script.push_back(static_cast<std::byte>(random() % 2 == 0 ? 0U : random()));
      }
    }
  }
  return styled::fuzz::WriteSeeds(argc, argv, seeds);
}
