// Pictures that grow, in a terminal and in tev.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>

#include "display/half_blocks.h"
#include "display/tev.h"

namespace tessera::client {
namespace {

/// Pixels of one grey, `count` samples each.
wire::TileResult tile(std::uint32_t x0, std::uint32_t y0, std::uint32_t x1, std::uint32_t y1, float grey,
                      std::uint32_t count) {
  wire::TileResult result;
  result.x0 = x0, result.y0 = y0, result.x1 = x1, result.y1 = y1;
  result.channels = {{"R"}, {"G"}, {"B"}};
  result.counts.assign(result.pixel_count(), count);
  result.values.assign(3 * result.pixel_count(), grey * static_cast<float>(count));
  return result;
}

TEST(GrowingImage, HasMeansOfCells) {
  GrowingImage image({10, 10, 14, 14}, 2, 2);
  const auto changed = image.add(tile(10, 10, 12, 14, 1, 3));
  ASSERT_TRUE(changed.ok());
  EXPECT_EQ(*changed, (Window{0, 0, 1, 2}));
  ASSERT_TRUE(image.add(tile(10, 10, 12, 14, 5, 1)).ok());
  EXPECT_FLOAT_EQ((*image.color(0, 1))[2], 2);
  EXPECT_FALSE(image.color(1, 0));
  image.clear();
  EXPECT_FALSE(image.color(0, 1));
  EXPECT_FALSE(image.add(tile(0, 0, 2, 2, 1, 1)).ok()) << "beyond the crop";
  wire::TileResult other = tile(10, 10, 12, 12, 1, 1);
  other.channels[0].name = "X";
  EXPECT_FALSE(image.add(other).ok());
}

TEST(HalfBlocks, KeepTheShapeOfThePicture) {
  EXPECT_EQ(half_block_cells({0, 0, 1600, 800}, 80, 40), (std::pair{80, 40}));
  EXPECT_EQ(half_block_cells({0, 0, 400, 800}, 80, 40), (std::pair{40, 80}));
  EXPECT_EQ(half_block_cells({0, 0, 20, 10}, 80, 40), (std::pair{20, 10})) << "no larger than it is";
  EXPECT_EQ(half_block_cells({0, 0, 10'000, 1}, 80, 0), (std::pair{80, 1}));
}

TEST(HalfBlocks, PaintTwoPixelsACharacter) {
  GrowingImage image({0, 0, 2, 3}, 2, 3);
  ASSERT_TRUE(image.add(tile(0, 0, 1, 3, 1, 1)).ok());
  ASSERT_TRUE(image.add(tile(1, 1, 2, 2, 0, 1)).ok());
  EXPECT_EQ(half_blocks(image),
            "\x1b[0m\x1b[38;2;255;255;255m\x1b[48;2;255;255;255m\u2580\x1b[0m\x1b[38;2;0;0;0m\u2584\x1b[0m\n"
            "\x1b[0m\x1b[38;2;255;255;255m\u2580\x1b[0m \x1b[0m\n");
}

TEST(Tev, MessagesAreThoseOfItsProtocol) {
  // Length, kind, focus, name, width, height, three channels.
  EXPECT_EQ(tev_create_image("a", 2, 258),
            std::string("\x1a\0\0\0\x04\0a\0\x02\0\0\0\x02\x01\0\0\x03\0\0\0R\0G\0B\0", 26));
  const std::string update = tev_update_image("a", {1, 2, 2, 3}, {0.5f, 1, 2});
  EXPECT_EQ(
      update.substr(0, 34),
      std::string("\x2e\0\0\0\x05\0a\0\x03\0\0\0R\0G\0B\0\x01\0\0\0\x02\0\0\0\x01\0\0\0\x01\0\0\0", 34));
  float last = 0;
  ASSERT_EQ(update.size(), 46u);
  std::memcpy(&last, update.data() + 42, sizeof(last));
  EXPECT_EQ(last, 2);
}

TEST(Tev, IsSentWhatResultsChange) {
  const int listener = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  ASSERT_EQ(::bind(listener, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(::listen(listener, 1), 0);
  ASSERT_EQ(::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size), 0);
  std::string expected, heard;
  {
    auto picture =
        TevPicture::open("127.0.0.1:" + std::to_string(ntohs(address.sin_port)), "a", {10, 20, 14, 24});
    ASSERT_TRUE(picture.ok()) << picture.status();
    ASSERT_TRUE(picture->add(tile(11, 21, 12, 23, 1, 3)).ok());
    ASSERT_TRUE(picture->add(tile(11, 21, 12, 23, 5, 1)).ok());
    EXPECT_TRUE(absl::IsInvalidArgument(picture->add(tile(0, 0, 1, 1, 1, 1))));
  }
  expected =
      tev_create_image("a", 4, 4) + tev_update_image("a", {1, 1, 2, 3}, std::vector<float>(6, 1.f)) +
      tev_update_image("a", {1, 1, 2, 3}, std::vector<float>(6, 2.f));  // the mean of 3 of 1 and 1 of 5
  const int viewer = ::accept(listener, nullptr, nullptr);
  char buffer[4096];
  for (ssize_t count = 0; (count = ::recv(viewer, buffer, sizeof(buffer), 0)) > 0;)
    heard.append(buffer, static_cast<std::size_t>(count));
  EXPECT_EQ(heard, expected);
  ::close(viewer);
  ::close(listener);
}

TEST(Tev, SaysThatNobodyListens) {
  EXPECT_TRUE(absl::IsUnavailable(Tev::connect("127.0.0.1:1").status()));
  EXPECT_TRUE(absl::IsInvalidArgument(Tev::connect("nowhere").status()));
}

}  // namespace
}  // namespace tessera::client
