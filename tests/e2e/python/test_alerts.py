"""The alert rules and the dashboard that the packages bring: promtool understands them, every alert fires when it must
and only then, and each metric in them is one that styleweb serves, used as what it is."""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from daemon import Daemon, wait_for
from gateway import Gateway

SKIPPED = 77
ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', '..')
FOLDER = os.path.join(ROOT, 'clients', 'web', 'prometheus')
RULES = os.path.join(FOLDER, 'styled.rules.yml')

HOST = 'instance="a:7080"'
ANNA = HOST + ',performer="rig.anna"'
LIVE = f'styled_performer_live{{{ANNA}}}'
REFUSED = f'styled_performer_refused_total{{{ANNA}}}'
RATE = '0+600x60'  # every 5 s, for five minutes


def per_performer(name, values, other, other_values):
    return {f'styled_performer_{name}{{{ANNA}}}': values, f'styled_performer_{other}{{{ANNA}}}': other_values}


def one(name, values, labels=HOST):
    return {f'{name}{{{labels}}}': values}


# Series of an alert: those that fire it, those beside them that must not. Values are Prometheus's: START+STEPxCOUNT.
CASES = {
    'StyledGatewayDown': ([one('up', '0x60', 'job="styled",' + HOST), {}], [one('up', '1x60', 'job="styled",' + HOST)]),
    'StyledDown': ([one('styled_up', '0x60')], [one('styled_up', '1x60'), one('styled_up', '1x29 0 1x29')]),
    'StyledPerformerRefused': ([{LIVE: '0x60', REFUSED: RATE}],
                               [{LIVE: '1x60', REFUSED: RATE}, {LIVE: '0x60', REFUSED: '7x60'}]),
    'StyledPerformerSilent': ([{LIVE: '0x60', REFUSED: '7x60'}],
                              [{LIVE: '1x60', REFUSED: '7x60'}, {LIVE: '0x60', REFUSED: RATE}]),
    'StyledFramesLost': ([per_performer('lost_total', '0+7x60', 'received_total', RATE)],
                         [per_performer('lost_total', '0+5x60', 'received_total', RATE)]),
    'StyledFramesLate': ([per_performer('over_budget_total', '0+7x60', 'published_total', RATE)],
                         [per_performer('over_budget_total', '0+5x60', 'published_total', RATE)]),
    'StyledOverloaded': ([one('styled_performer_overload_bypass', '1x60', ANNA)],
                         [one('styled_performer_overload_bypass', '0x60', ANNA)]),
    'StyledStyleFails': ([one('styled_stylist_failed_total', '0x55 1x4')], [one('styled_stylist_failed_total', '3x60')]),
    'StyledHardlyStyled': ([one('styled_performer_hardly_styled', '1x60', ANNA)],
                           [one('styled_performer_hardly_styled', '0x58 1x2', ANNA)]),
    'StyledSecondSender': ([one('styled_pipeline_second_sender_total', RATE)],
                           [one('styled_pipeline_second_sender_total', '9x60')]),
    'StyledLayerSilent': ([one('styled_performer_layer_live', '0x60', ANNA + ',source="gloves",part="fingers"')],
                          [one('styled_performer_layer_live', '1x60', ANNA + ',source="gloves",part="fingers"')]),
    'StyledSubscriberStalled': ([one('styled_publish_stalled_now', '2x60')], [one('styled_publish_stalled_now', '0x60')]),
    'StyledSubscribersMiss': ([one('styled_publish_canary_missed_total', RATE)],
                              [one('styled_publish_canary_missed_total', '9x60')]),
    'StyledRecordingLoses': ([one('styled_record_lost_total', RATE)], [one('styled_record_lost_total', '9x60')]),
    'StyledRecordingStopped': ([dict(one('styled_record_on', '1x29 0x30'), **one('styled_up', '1x60'))],
                               [dict(one('styled_record_on', '0x60'), **one('styled_up', '1x60')),
                                dict(one('styled_record_on', '1x60'), **one('styled_up', '1x60'))]),
    'StyledStateNotKept': ([one('styled_state_writes_failed_total', RATE)],
                           [one('styled_state_writes_failed_total', '9x60')]),
    'StyledReloadRefused': ([one('styled_config_reloads_refused_total', '0x29 1x30')],
                            [one('styled_config_reloads_refused_total', '1x60')]),
    'StyledStandbyPeerDown': ([one('styled_standby_peer_up', '0x60')], [one('styled_standby_peer_up', '1x60')]),
    'StyledStandbyNotReady': ([one('styled_standby_ready', '0x60')], [one('styled_standby_ready', '0x10 1x50')]),
    'StyledStandbyWithoutInput': ([one('styled_standby_without_input_performers', '1x60')],
                                  [one('styled_standby_without_input_performers', '0x60')]),
    'StyledTakeover': ([one('styled_standby_takeovers_total', '0x29 1x30')],
                       [one('styled_standby_takeovers_total', '1x60')]),
    'StyledKernelDrops': ([one('styled_source_kernel_dropped_total', RATE)],
                          [one('styled_source_kernel_dropped_total', '9x60')]),
    'StyledClockNotLocked': ([one('styled_clock_locked', '0x200')], [one('styled_clock_locked', '0x100 1x100')]),
    'StyledClientsRefused': ([dict(one('styled_security_refused_total', RATE),
                                   **one('styled_security_handshakes_failed_total', '0x60'))],
                             [dict(one('styled_security_refused_total', '0x40 2x20'),
                                   **one('styled_security_handshakes_failed_total', '0x60'))]),
}


def read(name):
    with open(os.path.join(FOLDER, name), encoding='utf-8') as file:
        return file.read()


def rules():
    """Name, expression, labels and annotations of each alert."""
    return re.findall(r'- alert: (\w+)\n +expr: (.*)\n(?: +for: \w+\n)? +labels: \{severity: (critical|warning|info)\}\n'
                      r' +annotations:\n +summary: "(.*)"\n +remedy: "(.*)"\n', read('styled.rules.yml'))


def expressions_of_dashboard():
    dashboard = json.loads(read('styled.dashboard.json'))
    return [target['expr'].replace('$__rate_interval', '1m') for panel in dashboard['panels'] for target in panel['targets']]


def promtool(*arguments, text=None):
    done = subprocess.run(['promtool', *arguments], input=text, text=True, capture_output=True)
    return done.returncode, done.stdout + done.stderr


def test_rules(cases):
    """promtool's verdict on (alert, series, whether it fires) for the rules as they are."""
    said = {name: (severity, summary, remedy) for name, _, severity, summary, remedy in rules()}
    tests = []
    for name, series, fires in cases:
        labels = dict(re.findall(r'(\w+)="([^"]*)"', ','.join(list(series)[:1]))) or {'job': 'styled'}
        severity, summary, remedy = said[name]
        annotations = {key: re.sub(r'\{\{ \$labels\.(\w+) \}\}', lambda found: labels.get(found[1], ''), text)
                       .replace('{{ $value }}', list(series.values() or ['0'])[0].split('x')[0])
                       for key, text in (('summary', summary), ('remedy', remedy))}
        end = '16m' if name == 'StyledClockNotLocked' else '5m'
        tests.append({'interval': '5s', 'input_series': [{'series': at, 'values': values} for at, values in series.items()],
                      'alert_rule_test': [{'eval_time': end, 'alertname': name, 'exp_alerts': [
                          {'exp_labels': dict(labels, severity=severity), 'exp_annotations': annotations}] if fires else []}]})
    with tempfile.NamedTemporaryFile('w', suffix='.yml') as file:
        json.dump({'rule_files': [RULES], 'evaluation_interval': '5s', 'tests': tests}, file)
        file.flush()
        return promtool('test', 'rules', file.name)


class RulesTest(unittest.TestCase):
    def test_every_rule_is_read_here(self):
        self.assertEqual([name for name, *_ in rules()], re.findall('alert: (.*)', read('styled.rules.yml')))
        self.assertEqual({name for name, *_ in rules()}, set(CASES))

    def test_promtool_takes_them(self):
        self.assertEqual(promtool('check', 'rules', RULES)[0], 0)

    def test_each_alert_fires_when_it_must_and_only_then(self):
        cases = [(name, series, fires) for name, (firing, quiet) in CASES.items()
                 for fires, several in ((True, firing), (False, quiet)) for series in several]
        code, text = test_rules(cases)
        self.assertEqual(code, 0, text)

    def test_promtool_would_say_so(self):
        for fires, series in ((True, CASES['StyledDown'][1][0]), (False, CASES['StyledDown'][0][0])):
            self.assertNotEqual(test_rules([('StyledDown', series, fires)])[0], 0)

    def test_promtool_takes_the_dashboard_s_expressions(self):
        found = expressions_of_dashboard()
        self.assertGreater(len(found), 20)
        with tempfile.NamedTemporaryFile('w', suffix='.yml') as file:
            json.dump({'groups': [{'name': 'dashboard', 'rules': [{'record': f'panel:{i}', 'expr': expression}
                                                                  for i, expression in enumerate(found)]}]}, file)
            file.flush()
            code, text = promtool('check', 'rules', file.name)
            self.assertEqual(code, 0, text)


class DashboardTest(unittest.TestCase):
    def test_panels_do_not_overlap_and_have_numbers_of_their_own(self):
        panels = json.loads(read('styled.dashboard.json'))['panels']
        self.assertEqual(len({panel['id'] for panel in panels}), len(panels))
        taken = set()
        for panel in panels:
            at = panel['gridPos']
            cells = {(x, y) for x in range(at['x'], at['x'] + at['w']) for y in range(at['y'], at['y'] + at['h'])}
            self.assertFalse(cells & taken, panel['title'])
            self.assertLessEqual(at['x'] + at['w'], 24)
            taken |= cells


class MetricsTest(unittest.TestCase):
    def exported(self):
        """Type by name, of a pair of daemons, one of which follows."""
        types = {}
        folder = tempfile.mkdtemp(prefix='styled-test-')
        self.addCleanup(shutil.rmtree, folder)
        addresses = [f'ipc://{folder}/{name}' for name in 'ab']
        for own, peer, first in ((0, 1, 'true'), (1, 0, 'false')):
            daemon = Daemon(extra=f'[standby]\naddress = "{addresses[own]}"\npeer = "{addresses[peer]}"\nfirst = {first}\n')
            self.addCleanup(daemon.close)
            gateway = Gateway(daemon)
            self.addCleanup(gateway.close)
            daemon.simulate()
            last = 'styled_standby_leads 1' if own == 0 else 'styled_standby_ready'
            wait_for(lambda: last in gateway.metrics(), last)
            types.update(re.findall(r'(?m)^# TYPE (\w+) (\w+)$', gateway.metrics()))
        return types

    def test_styleweb_serves_each_and_counters_are_counted(self):
        types = self.exported()
        types['up'] = 'gauge'  # Prometheus's own, of each target
        expressions = [expression for _, expression, *_ in rules()] + expressions_of_dashboard()
        used = 0
        for expression in expressions:
            bare = re.sub(r'\{[^}]*\}', '', expression)  # without labels
            for name in re.findall(r'\b(?:styled_\w+|styleweb_\w+|process_\w+|up)\b', bare):
                used += 1
                self.assertTrue(name in types, f'{name} in {expression}')
                counted = re.search(rf'\b(?:rate|increase)\({name}\[', bare) is not None
                self.assertEqual(types[name], 'counter' if counted else 'gauge', f'{name} in {expression}')
        self.assertGreater(used, 50)

    def test_counters_that_are_of_now_are_gauges(self):
        with open(os.path.join(ROOT, 'daemon', 'OPERATING.md'), encoding='utf-8') as page:
            now = re.findall(r'(?m)^\| `([a-z_]+\.[a-z_]+)` \| [^|]*, \*now\* \|', page.read())
        self.assertGreaterEqual(len(now), 6)
        daemon = Daemon()
        self.addCleanup(daemon.close)
        gateway = Gateway(daemon)
        self.addCleanup(gateway.close)
        wait_for(lambda: 'styled_record_' in gateway.metrics(), 'counters')
        types = dict(re.findall(r'(?m)^# TYPE (\w+) (\w+)$', gateway.metrics()))
        for counter in now:
            name = 'styled_' + re.sub('_us$', '_seconds', counter).replace('.', '_')
            self.assertEqual(types.get(name), 'gauge', name)


if __name__ == '__main__':
    if shutil.which('promtool') is None:
        print('skipped, no promtool (Debian: prometheus)')
        sys.exit(SKIPPED)
    unittest.main()
