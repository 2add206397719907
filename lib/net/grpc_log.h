// gRPC's own log, as part of the program's.
#pragma once

namespace tessera::net {

/// From here on gRPC's lines go to the program's log: errors, failed TLS handshakes above all, as warnings,
/// the rest for debugging. Of one kind, at most a few a minute: what others cause must not fill the disk. How
/// many are left out is said.
void log_grpc();

/// From here on gRPC logs nothing, unless $GRPC_VERBOSITY asks for it: people hear of it by the errors of
/// calls.
void mute_grpc();

}  // namespace tessera::net
