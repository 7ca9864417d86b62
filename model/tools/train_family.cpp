#include "model/tools/train_family.h"

#include <type_traits>

namespace styled::train {

void AddFlags(CLI::App& app, const std::vector<FlagGroup>& groups) {
  for (const FlagGroup& group : groups) {
    app.option_defaults()->group(group.name);
    for (const Flag& flag : group.flags) {
      const auto add = [&](auto* value) {
        using Value = std::remove_pointer_t<decltype(value)>;
        CLI::Option* const option = app.add_option(flag.name, *value, flag.meaning);
        constexpr bool kHasDefault =
            std::is_arithmetic_v<Value> || std::is_same_v<Value, std::string>;
        if (kHasDefault) option->capture_default_str();
        if (!flag.choices.empty()) option->check(CLI::IsMember(flag.choices));
      };
      std::visit(add, flag.value);
    }
  }
}

}  // namespace styled::train
