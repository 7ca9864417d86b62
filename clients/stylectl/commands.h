#pragma once

#include "clients/stylectl/session.h"

namespace styled::stylectl {

// Each function declares commands with their options and actions. The values parsed from the
// command line live as long as the session.
void DeclareShowCommands(Session& session);    // list, status
void DeclareStyleCommands(Session& session);   // set, clear, preset, cue, pin, unpin, panic, reset
void DeclareMakingCommands(Session& session);  // like, learn, vary
void DeclareDesign(Session& session);
void DeclareStyles(Session& session);
void DeclareCheckpoints(Session& session);  // checkpoint
void DeclareLead(Session& session);
void DeclareExplain(Session& session);
void DeclareCalibrate(Session& session);
void DeclareDoctor(Session& session);
void DeclareKeyCommands(Session& session);  // keygen, allow, revoke, keys

}  // namespace styled::stylectl
