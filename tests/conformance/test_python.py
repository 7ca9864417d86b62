"""The Python client reads the goldens to the same numbers (README.md)."""
import base64
import json
import os
import unittest

import styled
from styled.inbox import Inbox
from styled.v1 import body_pb2, frame_pb2

HERE = os.path.dirname(os.path.abspath(__file__))


def golden(name):
    with open(os.path.join(HERE, name + '.json')) as text:
        return json.load(text)


def plain(value):
    """A field in the goldens' form."""
    if isinstance(value, bytes):
        return base64.b64encode(value).decode()
    if hasattr(value, 'ListFields'):
        return {f.name: plain(getattr(value, f.name)) for f in value.DESCRIPTOR.fields}
    return [plain(v) for v in value] if hasattr(value, '__len__') and not isinstance(value, str) else value


def fields(message, expected):
    found = {}
    for name, value in expected.items():
        present = name != 'timecode' or message.HasField(name)
        found[name] = plain(getattr(message, name)) if present else None
        if isinstance(value, str):
            found[name] = str(found[name])
    return found


class ConformanceTest(unittest.TestCase):
    def test_reads_the_same_numbers(self):
        for name in ('canonical', 'fifty-five-joints', 'centimetres', 'hand'):
            expected = golden(name)
            body = body_pb2.Body.FromString(bytes.fromhex(expected['body']))
            self.assertEqual(fields(body, expected['body_fields']), expected['body_fields'])
            for entry in expected['frames']:
                frame = frame_pb2.Frame.FromString(bytes.fromhex(entry['frame']))
                self.assertEqual(fields(frame, entry['fields']), entry['fields'])
                world = styled.world_transforms(body, frame)
                self.assertEqual(len(world), len(entry['positions']))
                scale = max(1, *(abs(x) for p in entry['positions'] for x in p))
                for got, position, rotation in zip(world, entry['positions'], entry['rotations']):
                    for x, y in zip(got.position, position):
                        self.assertAlmostEqual(x, y, delta=1e-7 * scale)
                    sign = 1 if sum(map(lambda x, y: x * y, got.rotation, rotation)) > 0 else -1
                    for x, y in zip(got.rotation, rotation):
                        self.assertAlmostEqual(x, sign * y, delta=1e-7)
                positions, rotations = styled.world_arrays(body, frame)
                self.assertEqual((positions.shape, rotations.shape), ((len(world), 3), (len(world), 4)))

    def test_drops_what_is_to_be_refused(self):
        expected = golden('refused')
        good = bytes.fromhex(expected['body'])
        for kind, topic in (('bodies', b'body/rig.anna/'), ('frames', b'styled/rig.anna/rig/')):
            for entry in expected[kind]:
                inbox = Inbox('rig.anna')
                if kind == 'frames':
                    self.assertIsNotNone(inbox.accept([b'body/rig.anna/', good]))
                update = inbox.accept([topic, bytes.fromhex(entry['body' if kind == 'bodies' else 'frame'])])
                # A frame of another body may be one whose body is still to come.
                if entry['why'] == 'of another body':
                    self.assertIsNone(update.body)
                    continue
                self.assertIsNone(update, entry['why'])
                self.assertEqual(inbox.counters.malformed, 1, entry['why'])


if __name__ == '__main__':
    unittest.main()
