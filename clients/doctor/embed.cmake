# Writes daemon/OPERATING.md as a source: cmake -DIN=PAGE -DOUT=SOURCE -P embed.cmake
file(READ "${IN}" page HEX)
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${page}")
file(WRITE "${OUT}" "#include \"clients/doctor/operating_page.h\"

namespace styled::doctor {
namespace {
constexpr unsigned char kPage[] = {${bytes}};
}
std::string_view OperatingPage() {
  return {reinterpret_cast<const char*>(kPage), sizeof kPage};
}
}  // namespace styled::doctor
")
