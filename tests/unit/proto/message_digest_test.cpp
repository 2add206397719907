#include "wire/message_digest.h"

#include <gtest/gtest.h>

#include "tessera/v1/job.pb.h"

namespace tessera::wire {
namespace {

TEST(MessageDigest, DependsOnEveryFieldOfTheMessagesAndOnNoOther) {
  v1::JobSpec a, b;
  a.mutable_view()->set_width(640), b.mutable_view()->set_width(640);
  a.mutable_farm()->set_name("kitchen");
  EXPECT_EQ(digest_of({&a.content(), &a.view()}), digest_of({&b.content(), &b.view()}));
  b.mutable_view()->add_aovs(v1::AOV_DEPTH);
  EXPECT_NE(digest_of({&a.content(), &a.view()}), digest_of({&b.content(), &b.view()}));
}

TEST(MessageDigest, TellsMessagesApartThatHaveTheSameBytesInARow) {
  v1::JobSpec::Samples some, none;
  some.set_spp(7);
  EXPECT_NE(digest_of({&some, &none}), digest_of({&none, &some}));
}

}  // namespace
}  // namespace tessera::wire
