"""A second implementation of Sparkplug B (pysparkplug) at the gateway's broker.

read HOST PORT CA USER PASSWORD             each message as a line of JSON, until standard input ends
write HOST PORT CA USER PASSWORD DEVICE METRIC VALUE   one DCMD of the group `plant`, gateway `gw`; a number or a text
rebirth HOST PORT CA USER PASSWORD          one NCMD to it that asks for its births
"""

import json
import sys
import time

import pysparkplug as psp


def client(name, host, port, ca, user, password):
    one = psp.Client(
        client_id=name,
        username=user,
        password=password,
        transport_config=psp.TLSConfig(ca_certs=ca),
    )
    return one


def value(x):
    return x if isinstance(x, (bool, int, float, str, type(None))) else str(x)


def metrics_of(payload):
    # The library keeps the one metric of a death apart.
    death = getattr(payload, "bd_seq_metric", None)
    return [death] if death is not None else getattr(payload, "metrics", ())


def tell(_client, message):
    topic = message.topic
    line = {
        "kind": str(topic.message_type.value),
        "node": topic.edge_node_id,
        "device": topic.device_id,
        "qos": int(message.qos),
        "retain": bool(message.retain),
        "timestamp": message.payload.timestamp,
        "seq": getattr(message.payload, "seq", None),
        "metrics": [
            {
                "name": m.name,
                "alias": m.alias,
                "datatype": m.datatype.name,
                "value": value(m.value),
                "historical": bool(m.is_historical),
                "timestamp": m.timestamp,
            }
            for m in metrics_of(message.payload)
        ],
    }
    print(json.dumps(line), flush=True)


def read(host, port, ca, user, password):
    one = client("second-reader", host, port, ca, user, password)
    kinds = psp.MessageType
    for kind in (kinds.NBIRTH, kinds.NDEATH, kinds.NDATA):
        topic = psp.Topic(message_type=kind, group_id="plant", edge_node_id="+")
        one.subscribe(topic, psp.QoS.AT_LEAST_ONCE, tell)
    for kind in (kinds.DBIRTH, kinds.DDEATH, kinds.DDATA):
        topic = psp.Topic(message_type=kind, group_id="plant", edge_node_id="+", device_id="+")
        one.subscribe(topic, psp.QoS.AT_LEAST_ONCE, tell)
    one.connect(host, port=int(port), callback=lambda _: print('{"kind": "HERE"}', flush=True))
    sys.stdin.read()
    one.disconnect()


def number(text):
    try:
        return psp.DataType.DOUBLE, float(text)
    except ValueError:
        return psp.DataType.STRING, text


def publish(host, port, ca, user, password, topic, kind, name, datatype, said):
    one = client("second-writer", host, port, ca, user, password)
    one.connect(host, port=int(port))
    time.sleep(0.5)
    now = psp.get_current_timestamp()
    told = psp.Metric(timestamp=now, name=name, datatype=datatype, value=said)
    one.publish(
        psp.Message(
            topic=topic,
            payload=kind(timestamp=now, metrics=(told,)),
            qos=psp.QoS.AT_MOST_ONCE,
            retain=False,
        ),
        include_dtypes=True,
    )
    time.sleep(0.5)
    one.disconnect()


def write(host, port, ca, user, password, device, metric, text):
    topic = psp.Topic(
        message_type=psp.MessageType.DCMD, group_id="plant", edge_node_id="gw", device_id=device
    )
    datatype, said = number(text)
    publish(host, port, ca, user, password, topic, psp.DCmd, metric, datatype, said)


def rebirth(host, port, ca, user, password):
    topic = psp.Topic(message_type=psp.MessageType.NCMD, group_id="plant", edge_node_id="gw")
    name, datatype = "Node Control/Rebirth", psp.DataType.BOOLEAN
    publish(host, port, ca, user, password, topic, psp.NCmd, name, datatype, True)


{"read": read, "write": write, "rebirth": rebirth}[sys.argv[1]](*sys.argv[2:])
