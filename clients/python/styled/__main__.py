"""python3 -m styled: shows a daemon's frames and controls it, from a shell."""

import argparse
import os
import sys
import time
import warnings

import styled
from styled.commands import LOOK_FIELDS, ROOTS
from styled.look_options import LOOK_OPTIONS
from styled.v1 import look_pb2

EXIT_REFUSED, EXIT_USAGE, EXIT_NO_DAEMON = 1, 2, 3


def parse():
    parser = argparse.ArgumentParser(
        prog='python3 -m styled', description='Shows and controls a styled daemon.',
        epilog='Exit codes: 0 done, 1 the daemon refused, 2 usage, 3 no daemon answers (tail: '
               'nothing arrived within --seconds).')
    commands = parser.add_subparsers(dest='command', required=True, metavar='COMMAND')

    tail = commands.add_parser('tail', help='print frames as they arrive, one line per second or per frame')
    tail.add_argument('--publisher', action='append', metavar='ENDPOINT',
                      help='may be given many times (default: STYLED_PUBLISHER or '
                           f'{styled.DEFAULT_PUBLISHER})')
    tail.add_argument('--performer', default='', metavar='SOURCE.NAME', help='default: everyone')
    tail.add_argument('--stream', default='rig',
                      help='rig or canonical (both styled), source (as captured), or the name of an '
                           '[[output]]; default: rig')
    tail.add_argument('--frames', action='store_true', help='one line for each frame')
    tail.add_argument('--seconds', type=float, default=0, help='end by itself; 0: never')
    tail.set_defaults(run=run_tail)

    def command(name, text, run, performer):
        sub = commands.add_parser(name, help=text)
        endpoint = os.environ.get('STYLED_CONTROL', styled.DEFAULT_CONTROL)
        sub.add_argument('--control', default=endpoint, metavar='ENDPOINT',
                         help=f'default: STYLED_CONTROL or {styled.DEFAULT_CONTROL}')
        sub.add_argument('--timeout', type=float, default=2, help='seconds; default: 2')
        if performer:
            nargs = None if performer == 'required' else '?'
            sub.add_argument('performer', nargs=nargs, default=styled.EVERYONE, metavar='PERFORMER',
                             help="SOURCE.NAME, or '*' for everyone")
        sub.set_defaults(run=run)
        return sub

    command('list', 'styles, presets, cues, sliders', run_list, None)
    command('status', 'the daemon and its performers', run_status, None)
    change = command('set', 'change how a performer is styled', run_set, 'required')
    change.add_argument('--style', help='a single style')
    change.add_argument('--mix', action='append', metavar='STYLE=WEIGHT', help='several styles')
    for name in LOOK_FIELDS:
        if name == 'vary_each':
            continue  # a word of --vary
        options, text = look_options(name)
        change.add_argument(*options, dest=name, help=text, **look_kind(name))
    command('clear', 'fade to bypass', run_clear, 'optional')
    for name, text, run in (
            ('like', 'make a style from an example clip, and set the performer to it', run_like),
            ('learn', "make a style from the performer's motion from now on, and set the performer to it",
             run_learn)):
        make = command(name, text, run, 'required')
        make.add_argument('--name', required=name == 'learn',
                          help='name of the style, for all clients' +
                               ("; default: the file's name" if name == 'like' else ''))
        make.add_argument('--transition', type=in_unit('ms'), metavar='MS', help='fade')
        make.add_argument('--network', default='', metavar='NAME',
                          help='the network that gets the style; default: what the example shows decides')
        make.add_argument('--add', action='store_true',
                          help='add the example to the made style of that name')
        if name == 'like':
            make.add_argument('--clip', required=True, metavar='FILE',
                              help='the example: BVH, glTF binary or VRMA, 0.3 s or longer; its first 60 s are used')
            make.add_argument('--neutral', metavar='FILE',
                              help='a clip of the same performer moving as usual; only the difference '
                                   'from it is used')
            make.add_argument('--rig', default='auto', help="the example's rig dialect; default: auto")
            make.add_argument('--unworn', action='store_true',
                              help='only make the style, without setting a performer to it')
        else:
            make.add_argument('--seconds', type=take_seconds, default=8, metavar='S',
                              help='how long the performer shows it, 1 to 60; default: 8')
            make.add_argument('--neutral', type=take_seconds, metavar='S',
                              help='seconds of the performer moving as usual first; only the '
                                   'difference from them is used')
            make.add_argument('--countdown', type=int, default=3, metavar='S',
                              help='seconds before each; default: 3')
    design = command('design', 'make a style by hand, or move its sliders, and set the performer to it',
                     run_design, 'required')
    design.add_argument('sliders', nargs='*', type=slider, metavar='SLIDER=NUMBER',
                        help='as in `list`, e.g. stoop=28; the others keep their value')
    design.add_argument('--name', default='', help='name of the style; default: by-hand- and the performer')
    design.add_argument('--from', dest='from_', default='', metavar='STYLE',
                        help='the style to begin with; default: the made style of that name, or neutral')
    design.add_argument('--preset', default='', metavar='DESIGN',
                        help='set the sliders of this design first: one of `list`, or neutral')
    design.add_argument('--transition', type=in_unit('ms'), metavar='MS', help='fade')
    design.add_argument('--unworn', action='store_true',
                        help='only make the style, without setting a performer to it')
    cue = command('cue', 'fire the cues of that name', run_cue, None)
    cue.add_argument('name', metavar='NAME')
    command('panic', 'everyone to bypass, pinned or not', run_panic, None)
    arguments, rest = parser.parse_known_args()
    # argparse takes a list of words only before the options.
    if rest and (arguments.command != 'design' or any(word.startswith('-') for word in rest)):
        parser.error(f'unrecognized arguments: {" ".join(rest)}')
    try:
        arguments.sliders = getattr(arguments, 'sliders', []) + [slider(word) for word in rest]
    except argparse.ArgumentTypeError as error:
        parser.error(f'argument SLIDER=NUMBER: {error}')
    return parser, arguments


def describe(update):
    frame = update.frame
    styles = ' '.join(f'{s.style}={s.weight:.2f}' for s in frame.styles) or 'bypass'
    text = f'{frame.performer} {update.output_name or update.stream.value} {frame.sequence} {styles}'
    if update.body is not None:
        x, y, z = update.world()[0].position
        text += f' {update.body.names[0]} {x:.3f} {y:.3f} {z:.3f}'
    return text


def run_tail(a):
    publishers = a.publisher or [os.environ.get('STYLED_PUBLISHER', styled.DEFAULT_PUBLISHER)]
    came = {}  # performer: frames since the last line, the last update
    total, begun = 0, time.monotonic()
    end = begun + a.seconds if a.seconds > 0 else float('inf')
    line_begun = begun
    with styled.Subscriber(publishers, performer=a.performer,
                           streams=[a.stream]) as subscriber:
        while time.monotonic() < end:
            update = subscriber.receive(0.1)
            if update is not None and update.kind is styled.Kind.FRAME:
                total += 1
                came[update.frame.performer] = came.get(update.frame.performer, (0,))[0] + 1, update
                if a.frames:
                    print(describe(update), f'missed={update.missed}', flush=True)
            passed = time.monotonic() - line_begun
            if a.frames or passed < 1:
                continue
            line_begun += passed
            for performer, (frames, last) in sorted(came.items()):
                print(f'{frames / passed:.1f} Hz', describe(last),
                      f'missed={subscriber.counters.missed}', flush=True)
                came[performer] = 0, last
            if not came:
                here = f'connected to {subscriber.connected()} of {len(publishers)}'
                print(f'nothing yet; {here}', flush=True)
    return 0 if total or a.seconds <= 0 else EXIT_NO_DAEMON


def control(a):
    return styled.Control(a.control, timeout=a.timeout)


def run_list(a):
    with control(a) as daemon:
        reply = daemon.list()
    for style in reply.styles:
        evidence = [f'recognized {int(100 * style.recognized) / 100:.2f}{" (weak)" if style.weak else ""}'] \
            if style.recognized > 0 else []
        terms = [style.licence] if style.licence else []
        print(style.name, *(f'({alias})' for alias in style.aliases), *evidence, *terms)
    for cue in reply.cues:
        print(f'cue {cue.name}: {cue.performer}', *([f'at {cue.at}'] if cue.at else []))
    for preset in reply.presets:
        print(f'preset {preset.name}:', *(f'{w.style}={w.weight:g}' for w in preset.mix))
    for one in reply.sliders:
        print(f'slider {one.name}: {one.least:g} to {one.most:g}{" " + one.unit if one.unit else ""}, '
              f'usually {one.usual:g}. {one.what}')
    for one in reply.designs:
        print(f'design {one.name}:', *(f'{name}={value:g}' for name, value in sorted(one.sliders.items())))
    return 0


def run_status(a):
    with control(a) as daemon:
        status = daemon.status()
    print(f'styled {status.version}, up {status.uptime_s:.0f} s, weights {status.weights}')
    for source in status.sources:
        print(f'source {source.name}: {source.type} at {source.listen}, {source.received} received')
    for p in status.stats.performers:
        styles = ' '.join(f'{s.style}={s.weight:g}' for s in p.look.mix) or 'bypass'
        print(f'{p.performer}: {"live" if p.live else "silent"}, {p.rate_hz:.1f} Hz, {styles}, '
              f'strength {p.look.strength:g}, latency p99 {p.latency_p99_us:.0f} us, '
              f'{p.over_budget} frames later than a period')
    return 0


def say(applied, what):
    for performer, sequence in sorted(applied.items()):
        since = 'from their first frame' if performer in applied.absent else f'from frame {sequence} on'
        print(f'{performer}: {what}, {since}')
    if not applied:
        print('no performer is present yet; it applies to later ones')
    return 0


def weights(texts):
    mix = {}
    for text in texts:
        style, sign, weight = text.rpartition('=')
        try:
            mix[style] = float(weight)
        except ValueError:
            sign = ''
        if not sign or not style:
            raise ValueError(f"--mix '{text}', expected STYLE=WEIGHT")
    return mix


def look_options(field):
    """'--input-style' and '--from' of input_style, and what they do."""
    word, former, text = LOOK_OPTIONS[field]
    if field == 'vary':
        text += '; each: a different one per performer'
    return ['--' + name.replace('_', '-') for name in (word, former) if name], text.replace('%', '%%')


def in_unit(unit):
    def number(text):  # 5 or 5s; argparse names this function in its message
        return float(text.removesuffix(unit))
    return number


def variation(text):
    return text if text == 'each' else int(text)


def look_kind(field):
    kind = look_pb2.Look.DESCRIPTOR.fields_by_name[field]
    if kind.type == kind.TYPE_BOOL:
        return {'action': argparse.BooleanOptionalAction}
    if field == 'vary':
        return {'type': variation, 'metavar': '0..99|each'}
    if kind.type == kind.TYPE_FLOAT:
        unit = next((unit for unit in ('ms', 's') if field.endswith('_' + unit)), '')
        return {'type': in_unit(unit), 'metavar': unit.upper() or 'X'}
    if kind.type == kind.TYPE_ENUM and field == 'root':
        return {'choices': list(ROOTS)}
    return {'metavar': 'PART,...' if field == 'parts' else 'NAME'}


def run_set(a):
    fields = {name: getattr(a, name, None) for name in LOOK_FIELDS}
    if fields['vary'] is not None:
        fields['vary_each'] = fields['vary'] == 'each'
        fields['vary'] = 0 if fields['vary_each'] else fields['vary']
    if all(v is None for v in (a.style, a.mix, *fields.values())):
        raise ValueError('set: nothing to change, expected --style, --mix, --strength, ...')
    if fields['parts'] is not None:
        fields['parts'] = fields['parts'].split(',')
    mix = weights(a.mix) if a.mix else None
    with control(a) as daemon:
        return say(daemon.set(a.performer, style=a.style, mix=mix, **fields), 'set')


def take_seconds(text):
    seconds = in_unit('s')(text)
    if not 1 <= seconds <= 60:
        raise argparse.ArgumentTypeError(f'{text}, expected 1 to 60 s')
    return seconds


def say_style(reply, performer):
    of = f', of {reply.seconds:.2f} s' if reply.seconds > 0 else ''
    # A measured example is as good far from the known styles as near them.
    far = ': unlike all styles that the weights know, so a weak mixture of them' \
        if reply.distance > 1 and not reply.found else ''
    print(f'style {reply.name}{of}: nearest to {reply.nearest}, at {reply.distance:.2f} of the mean '
          f'distance between styles{far}')
    for line in reply.found:
        print(f'  found  {line}')
    for line in reply.weak:
        print(f'  weak   {line}')
    return say_style_of(performer, reply.name)


def say_style_of(performer, style):
    if performer is not None:
        print(f'{"everyone" if performer == styled.EVERYONE else performer}: {style}')
    return 0


def run_like(a):
    with control(a) as daemon:
        code = daemon.measure(a.neutral, rig=a.rig, network=a.network).code if a.neutral else ()
        performer = None if a.unworn else a.performer
        return say_style(daemon.like(performer, a.clip, a.name, rig=a.rig, transition_ms=a.transition,
                                     neutral_code=code, network=a.network, add=a.add), performer)


def slider(text):
    name, sign, number = text.partition('=')
    try:
        return name, float(number) if name and sign else float('')
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}', expected SLIDER=NUMBER, e.g. stoop=28, or a design after "
                                         '--preset') from None


def run_design(a):
    with control(a) as daemon:
        performer = None if a.unworn else a.performer
        reply = daemon.design(performer, dict(a.sliders), name=a.name, from_=a.from_, preset=a.preset,
                              transition_ms=a.transition)
    print(f'style {reply.name}, by hand')
    return say_style_of(performer, reply.name)


def count_down(seconds, take_s, what):
    print(what, end='', file=sys.stderr)
    for left in range(seconds, 0, -1):
        print(f'{left}... ', end='', file=sys.stderr, flush=True)
        time.sleep(1)
    print(f'now, for {take_s:g} s', file=sys.stderr, flush=True)


def run_learn(a):
    with control(a) as daemon:
        code = ()
        if a.neutral:
            count_down(a.countdown, a.neutral, 'as usual: ')
            code = daemon.measure_take(a.performer, a.neutral, a.network).code
        count_down(a.countdown, a.seconds, 'in the style: ' if a.neutral else '')
        return say_style(daemon.learn(a.performer, a.seconds, a.name, transition_ms=a.transition,
                                      neutral_code=code, network=a.network, add=a.add), a.performer)


def run_clear(a):
    with control(a) as daemon:
        return say(daemon.clear(a.performer), 'bypass')


def run_cue(a):
    with control(a) as daemon:
        return say(daemon.cue(a.name), 'fired')


def run_panic(a):
    with control(a) as daemon:
        return say(daemon.panic(), 'bypass')


def main():
    parser, arguments = parse()
    warnings.simplefilter('always', styled.Unseen)
    warnings.showwarning = lambda warning, *_: print(f'{parser.prog}: {warning}', file=sys.stderr)
    try:
        return arguments.run(arguments)
    except ValueError as error:
        parser.print_usage(sys.stderr)
        print(f'{parser.prog}: {error}', file=sys.stderr)
        return EXIT_USAGE
    except styled.Refused as error:
        print(f'{parser.prog}: {error}', file=sys.stderr)
        return EXIT_REFUSED
    except styled.Error as error:
        print(f'{parser.prog}: {error}', file=sys.stderr)
        return EXIT_NO_DAEMON
    except (KeyboardInterrupt, BrokenPipeError):
        sys.stderr.close()  # the reader has closed the pipe
        return 0
    except OSError as error:
        print(f'{parser.prog}: {error.filename}: {error.strerror}', file=sys.stderr)
        return EXIT_USAGE


if __name__ == '__main__':
    sys.exit(main())
