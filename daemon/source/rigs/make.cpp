#include "daemon/source/rigs/make.h"

#include "daemon/source/rigs/mocopi.h"
#include "daemon/source/rigs/mvn.h"
#include "daemon/source/rigs/rokoko.h"
#include "daemon/source/rigs/slimevr.h"
#include "daemon/source/rigs/slimevr_hid.h"
#include "daemon/source/rigs/vmc.h"

namespace styled::source {

std::unique_ptr<Translator> MakeTranslator(const config::Source& config) {
  if (config.type == "mvn" || config.type == "mvn-tcp") return MakeMvn(config);
  if (config.type == "mocopi") return MakeMocopi(config);
  if (config.type == "rokoko") return MakeRokoko(config);
  if (config.type == "slimevr") return MakeSlimeVr(config);
  if (config.type == "vmc") return MakeVmc(config);
  if (config.type == "slimevr-usb") return MakeSlimeVrHid(config);
  return nullptr;
}

}  // namespace styled::source
