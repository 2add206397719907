#include "wire/digest.h"

#include <gtest/gtest.h>

namespace tessera::wire {
namespace {

// FIPS 180-4, examples of the NIST.
constexpr char kEmpty[] = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
constexpr char kAbc[] = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

TEST(Digest, GivesThePublishedValues) {
  EXPECT_EQ(sha256_hex(""), kEmpty);
  EXPECT_EQ(sha256_hex("abc"), kAbc);
}

TEST(Digest, PiecesGiveTheSameAsTheWholeAndTheObjectStartsAnew) {
  Sha256 sha;
  sha.update("a");
  sha.update("");
  sha.update("bc");
  EXPECT_EQ(sha.finish_hex(), kAbc);
  EXPECT_EQ(sha.finish_hex(), kEmpty);
}

TEST(Digest, OnlyLowerCaseHexadecimalOfFullLengthIsOne) {
  EXPECT_TRUE(is_digest(kAbc));
  std::string text = kAbc;
  EXPECT_FALSE(is_digest(text + "0"));
  EXPECT_FALSE(is_digest(text.substr(1)));
  text[10] = 'A';
  EXPECT_FALSE(is_digest(text));
  text[10] = '/';
  EXPECT_FALSE(is_digest(text));
}

}  // namespace
}  // namespace tessera::wire
