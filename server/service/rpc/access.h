// Who calls, and what their certificate allows them to do.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

#include "service/farm/rights.h"
#include "tls/expelled.h"
#include "tls/members.h"

namespace grpc {
class AuthMetadataProcessor;
}

namespace tessera::server {

Caller caller_of(const grpc::AuthContext* context);
/// The certificate itself, in PEM; empty where there is none.
std::string certificate_of(const grpc::AuthContext& context);

/// Refuses, and logs, every call that the caller's role is not for, before it reaches a service: workers call
/// WorkService and download blobs, clients call FarmService and upload blobs, administrators do what clients
/// do, trust hosts again, download blobs, make join tokens and expel others. Everybody may ask for health.
/// But whoever is expelled may do nothing. Who calls is noted in `members`.
std::shared_ptr<grpc::AuthMetadataProcessor> access_by_role(std::shared_ptr<const Expelled> expelled,
                                                            std::shared_ptr<Members> members);

/// Refuses, and logs, all but JoinService, for callers without a certificate.
std::shared_ptr<grpc::AuthMetadataProcessor> access_to_joining();

}  // namespace tessera::server
