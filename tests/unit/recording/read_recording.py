#!/usr/bin/env python3
"""Reads a recording by proto/recording/FORMAT.md, with nothing of ours: Python's standard library and
the zstd command. Prints one line per block and, at the end, per kind of record how many there are:

    blocks=4 records=12 arrival=3 published=3 command=3 note=3 datagram_bytes=96 damage=0 tail=0
"""
import struct
import subprocess
import sys

BLOCK = struct.Struct('<4sBBHIIIIqqII')
MAX_SIZE = 4194304


def crc32c(data, table=[]):
    if not table:
        for byte in range(256):
            for _ in range(8):
                byte = byte >> 1 ^ (0x82F63B78 if byte & 1 else 0)
            table.append(byte)
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ table[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


def block_at(data, at):
    """(header fields, payload), None where there is no block, or 'cut' where its end is missing."""
    head = data[at:at + BLOCK.size]
    if len(head) < BLOCK.size:
        return 'cut' if head[:4] == b'\xf5SBK'[:len(head)] else None
    fields = BLOCK.unpack(head)
    if fields[0] != b'\xf5SBK' or fields[11] != crc32c(head[:44]) or max(fields[4:6]) > MAX_SIZE:
        return None
    payload = data[at + BLOCK.size:at + BLOCK.size + fields[4]]
    if len(payload) < fields[4]:
        return 'cut'
    return (fields, payload) if crc32c(payload) == fields[7] else None


def varint(data, at):
    value = shift = 0
    while True:
        byte = data[at]
        value |= (byte & 0x7F) << shift
        at, shift = at + 1, shift + 7
        if byte < 0x80:
            return value, at


def fields_of(message):
    """(number, value) of each field of a protobuf message; bytes of those with a length."""
    at = 0
    while at < len(message):
        key, at = varint(message, at)
        if key & 7 == 0:
            value, at = varint(message, at)
        elif key & 7 == 2:
            size, at = varint(message, at)
            assert at + size <= len(message), 'a field beyond its message'
            value, at = message[at:at + size], at + size
        else:
            size = {1: 8, 5: 4}[key & 7]
            value, at = message[at:at + size], at + size
        yield key >> 3, value


def messages_of(fields, payload):
    if fields[2] == 1:
        payload = subprocess.run(['zstd', '-dc'], input=payload, stdout=subprocess.PIPE,
                                 check=True).stdout
    assert len(payload) == fields[5], 'raw size'
    at = 0
    while at < len(payload):
        size, at = varint(payload, at)
        assert at + size <= len(payload), 'a message beyond its block'
        yield payload[at:at + size]
        at += size


def main(path):
    with open(path, 'rb') as file:
        data = file.read()
    assert data[:8] == b'\x89STYR\r\n\x1a', 'not a recording'
    assert struct.unpack('<I', data[8:12])[0] == 1, 'another version'
    kinds = {2: 'arrival', 3: 'published', 4: 'command', 5: 'note'}
    counts = dict.fromkeys(kinds.values(), 0)
    at, blocks, records, damage, datagram_bytes, tail = 16, 0, 0, 0, 0, 0
    while at < len(data):
        found = block_at(data, at)
        if not isinstance(found, tuple):
            search, cut = at, at if found == 'cut' else len(data)
            while search < len(data) and not isinstance(found, tuple):
                search = data.find(b'\xf5SBK', search + 1)
                search = len(data) if search < 0 else search
                found = block_at(data, search)
                if found == 'cut' and search < len(data):
                    cut = min(cut, search)
            if not isinstance(found, tuple):
                damage, tail = damage + cut - at, len(data) - cut
                break
            damage, at = damage + search - at, search
        fields, payload = found
        blocks += 1
        print('offset %d: type %d, number %d, %d messages, %d bytes (%d raw), time %d to %d ns' %
              (at, fields[1], fields[10], fields[6], fields[4], fields[5], fields[8], fields[9]))
        if fields[1] == 1:
            header = dict(fields_of(next(messages_of(fields, payload))))
            print('  header: program %s' % header.get(3, b'').decode())
        elif fields[1] == 2:
            messages = list(messages_of(fields, payload))
            assert len(messages) == fields[6], 'number of messages'
            for message in messages:
                record = dict(fields_of(message))
                time_ns = record.get(1, 0) - (1 << 64 if record.get(1, 0) >> 63 else 0)
                assert fields[8] <= time_ns <= fields[9], 'a time outside of its block'
                records += 1
                for number, kind in kinds.items():
                    counts[kind] += number in record
                if 2 in record:
                    datagram_bytes += len(dict(fields_of(record[2])).get(5, b''))
        at += BLOCK.size + len(payload)
    print('blocks=%d records=%d %s datagram_bytes=%d damage=%d tail=%d' %
          (blocks, records, ' '.join('%s=%d' % item for item in counts.items()), datagram_bytes,
           damage, tail))


if __name__ == '__main__':
    main(sys.argv[1])
