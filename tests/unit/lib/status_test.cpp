#include "net/status.h"

#include <gmock/gmock.h>
#include <grpcpp/support/status.h>
#include <gtest/gtest.h>

namespace tessera::net {
namespace {

TEST(Status, EveryCodeSurvivesTheWay) {
  for (int code = 0; code <= 16; ++code) {
    const absl::Status status(static_cast<absl::StatusCode>(code), "why");
    EXPECT_EQ(from_grpc(to_grpc(status), "Lease at here").code(), status.code());
  }
}

TEST(Status, TheMessageNamesTheCall) {
  const absl::Status status =
      from_grpc({grpc::StatusCode::NOT_FOUND, "no job 7"}, "GetJob at 127.0.0.1:7070");
  EXPECT_EQ(status.message(), "GetJob at 127.0.0.1:7070: no job 7");
  EXPECT_TRUE(from_grpc(grpc::Status::OK, "GetJob").ok());
  EXPECT_EQ(from_grpc({grpc::StatusCode::NOT_FOUND, "\x1b[2J\rno\njob"}, "GetJob").message(),
            "GetJob: \\x1b[2J\\x0dno\\njob");
  // gRPC itself says nothing.
  EXPECT_GT(from_grpc({grpc::StatusCode::UNIMPLEMENTED, ""}, "GetJob").message().size(), sizeof("GetJob: "));
}

}  // namespace
}  // namespace tessera::net
