#include "clients/stylectl/cli.h"

#include <utility>

#include "clients/stylectl/commands.h"
#include "clients/stylectl/session.h"
#include "model/base/clean_stream.h"

namespace styled::stylectl {

int Run(std::vector<std::string> arguments, std::ostream& out, std::ostream& err) {
  CleanStream clean_out(out), clean_err(err);
  Session session(clean_out, clean_err, out);
  // In the order in which --help lists the commands.
  DeclareShowCommands(session);
  DeclareStyleCommands(session);
  DeclareMakingCommands(session);
  DeclareDesign(session);
  DeclareStyles(session);
  DeclareCheckpoints(session);
  DeclareLead(session);
  DeclareExplain(session);
  DeclareCalibrate(session);
  DeclareDoctor(session);
  DeclareKeyCommands(session);
  return session.Run(std::move(arguments));
}

}  // namespace styled::stylectl
