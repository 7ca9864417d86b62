#include "clients/vmc/find_target.h"

namespace styled::stylevmc {

Result<std::vector<TargetSpec>> FindTargets(const std::vector<std::string>& texts,
                                            bool /*vrchat*/) {
  if (texts.empty()) return std::vector<TargetSpec>();
  return Status::Error(
      "--find: this build has no mDNS; build it with libavahi-client-dev installed, or give --to");
}

}  // namespace styled::stylevmc
