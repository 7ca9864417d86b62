#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "proto/rigs/slimevr/hid.h"
#include "proto/rigs/slimevr/udp.h"

// Bytes as trackers and receivers write them, put down by hand from the order in which SlimeVR's
// firmware writes its fields (nRF connection.c and the receiver's hid.c; ESP connection.cpp and
// packets.h), and ways to get them wrong. Shared by the unit tests and, as seeds, by the fuzzer.
namespace styled::slimevr::testing {

using Bytes = std::vector<std::byte>;

inline Bytes Hex(std::string_view text) {
  const auto digit = [](char c) { return c <= '9' ? c - '0' : c - 'A' + 10; };
  Bytes bytes;
  for (std::size_t i = 0; i < text.size();) {
    if (text[i] == ' ') {
      ++i;
      continue;
    }
    bytes.push_back(static_cast<std::byte>(digit(text[i]) * 16 + digit(text[i + 1])));
    i += 2;
  }
  return bytes;
}

inline Bytes Join(std::initializer_list<Bytes> parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

// Receiver's records. 87 % is D7, 3.95 V is 150 = 96, 31 degrees are 140 = 8C, sqrt(1/2) in Q15,
// cut off, is 23170 = 5A82, 1 g in Q7 is 1255 = 04E7.
inline const Bytes kInfoRecord =
    Hex("00 03 D7 96 8C 09 0A 00 0D 02 8C 0C 01 02 03 3C");  // built 2026-04-12, version 1.2.3
inline const Bytes kMotionRecord = Hex("01 03 00 00 00 00 82 5A 82 5A 00 00 00 00 E7 04");
inline const Bytes kMotionAndBatteryRecord = Hex("02 03 D7 96 8C 00 02 10 C0 80 FF 40 00 E7 04 3C");
inline const Bytes kStatusRecord = Hex("03 03 01 07 64 02 63 01 00 00 00 00 00 00 00 3C");
inline const Bytes kMagnetometerRecord = Hex("04 03 00 00 00 00 00 00 FF 7F 00 02 00 00 00 FE");
inline const Bytes kRuntimeRecord = Hex("05 03 00 A4 93 D6 00 00 00 00 00 00 00 00 00 3C");
inline const Bytes kButtonRecord = Hex("06 03 01 10 27 00 00 00 00 00 00 00 00 00 00 3C");
inline const Bytes kMotionAndButtonRecord = Hex("07 03 02 FF FF 00 02 10 80 00 00 00 00 E7 04 3C");
// The server's own test of registrations (HidPacketV3Test.kt) has this address for this number.
inline const Bytes kRegistrationRecord = Hex("FF 02 05 04 03 02 01 00 00 00 00 00 00 00 00 00");

struct ReportCase {
  std::string name;
  Bytes bytes;
  ReportResult expected;
};

inline std::vector<ReportCase> ReportCases() {
  using R = ReportResult;
  const Bytes unknown = Hex("FD 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00");
  const Bytes four = Join({kMotionRecord, kMotionAndBatteryRecord, kStatusRecord, kInfoRecord});
  Bytes ragged = four;
  ragged.pop_back();
  return {
      {"nothing", {}, R::kEmpty},
      {"one byte", Hex("01"), R::kRagged},
      {"a record less a byte", Bytes(15), R::kRagged},
      {"a report less a byte", ragged, R::kRagged},
      {"five records", Join({four, kMotionRecord}), R::kTooLong},
      {"a report of four", four, R::kOk},
      {"another report of four",
       Join({kMagnetometerRecord, kRuntimeRecord, kButtonRecord, kMotionAndButtonRecord}), R::kOk},
      {"one record", kMotionRecord, R::kOk},
      {"registrations and a type to come", Join({kRegistrationRecord, unknown}), R::kOk},
      {"a rotation of zeros", Join({Hex("01 07"), Bytes(14)}), R::kOk},
  };
}

// Trackers' datagrams: type, number, body.
inline Bytes Header(std::string_view type, std::string_view number) {
  return Join({Hex("00 00 00"), Hex(type), Hex("00 00 00 00 00 00 00"), Hex(number)});
}

// Board 9 (SlimeVR), BNO085, ESP8266, three unused words, protocol 22, "0.7.2", MAC; then what
// newer firmware adds: tracker type, vendor, its URL, product, update address and name.
inline const Bytes kHandshake =
    Join({Header("03", "00"), Hex("00 00 00 09 00 00 00 04 00 00 00 01"), Bytes(12),
          Hex("00 00 00 16 05 30 2E 37 2E 32 A8 48 FA C0 1D 42 00"),
          Hex("07 53 6C 69 6D 65 56 52 00 08 53 6C 69 6D 65 20 76 31 00 00")});
// 0.5, 0.5, -0.5, 0.5 as floats.
inline const Bytes kRotation =
    Join({Header("11", "07"), Hex("01 01 3F 00 00 00 3F 00 00 00 BF 00 00 00 3F 00 00 00 02")});
inline const Bytes kSensorInfo =
    Join({Header("0F", "05"), Hex("01 01 0D 00 03 01 0F 00 42 C8 00 00 42 C8 00 00")});
// Compact motion: sensor, Q15 x y z w, Q7.
inline const Bytes kMotionBody = Hex("02 00 00 00 00 5A 82 5A 82 00 00 FF 80 04 E7");
// As BUFFERED firmware bundles: one header, then u16 length, u32 type, body each.
inline const Bytes kBundle =
    Join({Header("64", "09"), Hex("00 17 00 00 00 11"),
          Hex("01 01 3F 00 00 00 3F 00 00 00 BF 00 00 00 3F 00 00 00 02"), Hex("00 11 00 00 00 04"),
          Hex("3F 80 00 00 C0 00 00 00 41 1C E8 0A 01")});
inline const Bytes kCompactBundle =
    Join({Header("65", "0A"), Hex("10 17"), kMotionBody, Hex("03 0D 01 02")});

struct UdpCase {
  std::string name;
  Bytes bytes;
  UdpResult expected;
};

inline std::vector<UdpCase> UdpCases() {
  using R = UdpResult;
  const auto cut = [](Bytes bytes, std::size_t by) {
    bytes.resize(bytes.size() - by);
    return bytes;
  };
  const Bytes deep = Join({Header("65", "01"), Hex("05 65 03 65 01 00")});
  const Bytes two_deep = Join({Header("65", "01"), Hex("03 65 01 00")});
  Bytes many = Header("65", "01");
  for (std::size_t i = 0; i < kMaxPackets; ++i) many = Join({many, Hex("01 00")});
  std::vector<UdpCase> cases{
      {"nothing", {}, R::kTooShort},
      {"a header less a byte", Bytes(11), R::kTooShort},
      {"heartbeat", Header("00", "01"), R::kOk},
      {"handshake", kHandshake, R::kOk},
      {"handshake of nothing", Header("03", "00"), R::kOk},
      {"handshake without MAC", cut(kHandshake, 27), R::kOk},
      {"handshake whose firmware leaves it", cut(kHandshake, 28), R::kTooShort},
      {"rotation", kRotation, R::kOk},
      {"rotation without accuracy", cut(kRotation, 1), R::kOk},
      {"rotation less w's last byte", cut(kRotation, 2), R::kTooShort},
      {"legacy rotation less a byte", Join({Header("01", "02"), Bytes(13), Hex("3F 80")}),
       R::kTooShort},
      {"sensor info", kSensorInfo, R::kOk},
      {"sensor info of old firmware", cut(kSensorInfo, 13), R::kOk},
      {"sensor info of a byte", cut(kSensorInfo, 15), R::kTooShort},
      {"compact motion", Join({Header("17", "03"), kMotionBody}), R::kOk},
      {"compact motion less a byte", cut(Join({Header("17", "03"), kMotionBody}), 1), R::kTooShort},
      {"a text that leaves it", Join({Header("0B", "04"), Hex("00 00 00 05 61 62")}), R::kTooShort},
      {"a text of 4 GiB", Join({Header("0B", "04"), Hex("FF FF FF FF 61 62")}), R::kTooShort},
      {"a type to come", Join({Header("1C", "04"), Bytes(16)}), R::kOk},
      {"bundle", kBundle, R::kOk},
      {"compact bundle", kCompactBundle, R::kOk},
      {"bundle with a length that leaves it, packet whole",
       Join({Header("65", "01"), Hex("FF 0D 01 02")}), R::kOk},
      {"bundle with half a length", Join({Header("64", "01"), Hex("00")}), R::kTooShort},
      {"bundle with half a type", Join({Header("64", "01"), Hex("00 02 00 00")}), R::kTooShort},
      {"bundle with a packet cut short", cut(kCompactBundle, 1), R::kTooShort},
      {"bundle of nothing", Header("64", "01"), R::kOk},
      {"bundle of empty lengths", Join({Header("64", "01"), Bytes(8)}), R::kOk},
      {"bundle in a bundle", two_deep, R::kOk},
      {"bundle in a bundle in a bundle", deep, R::kTooDeep},
      {"as many packets as there may be", many, R::kOk},
      {"one packet more", Join({many, Hex("01 00")}), R::kTooMany},
  };
  // Bodies of all types, each as short as it may be, and cut by a byte.
  const std::initializer_list<std::pair<std::string_view, std::string_view>> bodies{
      {"01", "00 00 00 00 00 00 00 00 00 00 00 00 3F 80 00 00"},
      {"10", "00 00 00 00 00 00 00 00 00 00 00 00 3F 80 00 00"},
      {"04", "3F 80 00 00 C0 00 00 00 41 1C E8 0A"},
      {"0A", "CA FE BA BE"},
      {"0B", "00 00 00 02 68 69"},
      {"0C", "3F 40 00 00"},
      {"0D", "01 02"},
      {"0E", "00 2A"},
      {"0F", "01 02"},
      {"11", "03 02 00 00 00 00 00 00 00 00 00 00 00 00 3F 80 00 00"},
      {"12", "00 3F 00 00 00"},
      {"13", "FF C4"},
      {"15", "03"},
      {"17", "00 00 00 00 00 00 00 7F FF 00 00 00 00 00 00"},
      {"18", "FF 00 01"},
      {"1A", "04 3F 00 00 00"},
      {"1B", "04 3F 00 00 00 00 00 00 00 00 00 00 00"},
      {"C8", "01 02"},
  };
  for (const auto& [type, body] : bodies) {
    const Bytes whole = Join({Header(type, "02"), Hex(body)});
    cases.push_back({"type " + std::string(type), whole, R::kOk});
    cases.push_back({"type " + std::string(type) + " less a byte", cut(whole, 1), R::kTooShort});
  }
  return cases;
}

}  // namespace styled::slimevr::testing
